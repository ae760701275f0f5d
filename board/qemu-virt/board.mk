# QEMU's `virt` machine with 4 Cortex-A72.
include make/bare.mk
