# U-Boot runs this at each start, from a FAT that nobody ever writes: an update changes slots and
# the state alone. On both Debian's U-Boot for RK3399 boards, which has no setexpr, and for QEMU.
#
# The state, {good, trial, left}, stands in two raw sectors, each with a CRC ("env export -c"), in
# an erase block of 4 MiB of its own: 0x2000 and 0x6000. Copy 1 is written first: while one is torn
# the other is whole. A trial has so many starts left; each is counted before it is made. Whatever
# does not load, or whose SHA-256 is wrong, is passed over.
setenv first 2000
setenv second 6000
setenv good
setenv trial
setenv left
setenv fit 10000000
if test "${board}" = qemu-arm; then
  setenv fit 60000000
  setenv kernel_comp_addr_r 50000000
  setenv kernel_comp_size 4000000
fi

${devtype} dev ${devnum}
${devtype} read ${scriptaddr} ${first} 1
if env import -c ${scriptaddr} 200 good trial left; then
  echo PIRVS: state of copy 1
else
  ${devtype} read ${scriptaddr} ${second} 1
  if env import -c ${scriptaddr} 200 good trial left; then
    echo PIRVS: state of copy 2
  else
    echo PIRVS: no state, slot a
    setenv good a
    setenv trial
    setenv left 0
  fi
fi

setenv slot ${good}
if test -n "${trial}"; then
  setenv after
  if test "${left}" = 3; then setenv after 2; fi
  if test "${left}" = 2; then setenv after 1; fi
  if test "${left}" = 1; then setenv after 0; fi
  if test -n "${after}"; then
    setenv left ${after}
    env export -c -s 200 ${scriptaddr} good trial left
    ${devtype} write ${scriptaddr} ${first} 1
    ${devtype} write ${scriptaddr} ${second} 1
    setenv slot ${trial}
  fi
fi
echo PIRVS: good=${good} trial=${trial} left=${left}, starting ${slot}

for s in ${slot} ${good} a b; do
  setenv whole
  part start ${devtype} ${devnum} kernel-${s} begin
  part size ${devtype} ${devnum} kernel-${s} sectors
  if ${devtype} read ${fit} ${begin} ${sectors}; then
    if imxtract ${fit} kernel ${kernel_addr_r}; then
      if imxtract ${fit} fdt ${fdt_addr_r}; then
        if imxtract ${fit} initramfs; then setenv whole yes; fi
      fi
    fi
  fi
  if test -n "${whole}"; then
    if test "${board}" = qemu-arm; then setenv fdt_addr_r ${fdtcontroladdr}; fi
    # panic: start again after 2 s. gpt: the copy at the card's end will do.
    setenv bootargs "quiet panic=2 gpt rauc.slot=${s} ${extra}"
    booti ${kernel_addr_r} ${fileaddr}:${filesize} ${fdt_addr_r}
  fi
  echo PIRVS: slot ${s} does not start
done
reset
