# A PC with cameras and an IMU: the device program as it runs on any, over the host's library.
CXX_LINUX = $(CXX)
BINUTILS :=
MACHINE := -march=x86-64-v3
LIBGPIOD := /usr/lib/$(shell uname -m)-linux-gnu/libgpiod.a
LIBS_LINUX := -ljpeg
shared_objects = $(BUILD)/host/libpirvs.a
include make/linux.mk
$(BUILD)/host/libpirvs.a: FORCE
	@$(MAKE) -s BOARD=host $@
