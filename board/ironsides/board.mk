# RK3399 under Linux: two Cortex-A72 and four Cortex-A53.
include make/aarch64.mk
CXX_LINUX = $(CXX_AARCH64)
MACHINE = $(AARCH64)
shared_objects = $(aarch64_objects)
# Debian's, for arm64; its header is that of the host's package.
LIBGPIOD := $(BUILD)/aarch64/libgpiod/usr/lib/aarch64-linux-gnu/libgpiod.a
include make/linux.mk
$(LIBGPIOD): | $(BUILD)/setup.stamp
	@tools/setup/fetch_packages arm64 $(BUILD)/aarch64/libgpiod libgpiod-dev

# The card is for this one; of others Debian has U-Boot and device tree as well.
UBOOT ?= rock-pi-4-rk3399
DTB ?= rk3399-rock-pi-4b.dtb
include make/image.mk
