# RK3399 behind U-Boot: two Cortex-A72 and four Cortex-A53, and the card that it starts from.
include make/bare.mk

UBOOT ?= rock-pi-4-rk3399
ifeq ($(filter %-rk3399,$(UBOOT)),)
  $(error UBOOT=$(UBOOT): not for an RK3399; docs/board-bringup.md names those there are)
endif
FIRMWARE := $(BUILD)/uboot/usr/lib/u-boot/$(UBOOT)
CARD := $(OUT)/card.img
RECORDING := $(OUT)/recording.pack

.PHONY: image firmware flash flash-usb
# The application for QEMU lies beside the board's: with it the card itself is booted in a test.
image: $(OUT)/pirvs.bin $(FIRMWARE)/idbloader.img ## card.img for SD or eMMC; SEQ=path UBOOT=board
	@$(MAKE) -s BOARD=qemu-virt all
	@$(MAKE) -s BOARD=host all $(if $(filter $(SIM),$(SEQ)),$(SIM).done)
	@$(BUILD)/host/pirvs pack $(SEQ) --out $(RECORDING) --duration $(DURATION)
	@tools/image/build --out $(CARD) --firmware $(FIRMWARE) /recording.bin=$(RECORDING) \
	  /pirvs-rk3399-bare.bin=$(OUT)/pirvs.bin /pirvs-qemu-virt.bin=$(BUILD)/qemu-virt/pirvs.bin \
	  /extlinux/extlinux.conf=board/$(BOARD)/extlinux.conf
	@tools/image/bill --image $(CARD) --name pirvs-rk3399-bare --version $(REVISION) \
	  --time $(or $(shell git log -1 --format=%ct 2>/dev/null),0) --packages $(BUILD)/uboot/packages \
	  $(addprefix --static ,picolibc-aarch64-linux-gnu libgcc-12-dev-arm64-cross libeigen3-dev) \
	  --compiler g++-12-aarch64-linux-gnu

firmware: $(FIRMWARE)/idbloader.img ## Debian's U-Boot for this board alone

flash: ## write the card: DEV=/dev/sdX
	@tools/image/flash $(CARD) $(DEV)

flash-usb: ## write the eMMC over USB; LOADER=file in mask ROM mode
	@tools/image/flash_usb $(CARD) $(LOADER)

$(FIRMWARE)/idbloader.img:
	@tools/image/fetch_uboot $(BUILD)/uboot
	@[ -e $@ ] || { echo "image: no U-Boot for $(UBOOT); UBOOT= one of:" \
	  $$(cd $(BUILD)/uboot/usr/lib/u-boot && echo *-rk3399) >&2; exit 2; }
