# RK3399 under Linux: two Cortex-A72 and four Cortex-A53.
include make/aarch64.mk
CXX_LINUX = $(CXX_AARCH64)
MACHINE = $(AARCH64)
shared_objects = $(aarch64_objects)
include make/linux.mk

# The card is for this one; of others Debian has U-Boot and device tree as well.
UBOOT ?= rock-pi-4-rk3399
DTB ?= rk3399-rock-pi-4b.dtb
include make/image.mk
