# RK3399 under Linux: two Cortex-A72 and four Cortex-A53.
include make/aarch64.mk
CXX_LINUX = $(CXX_AARCH64)
MACHINE = $(AARCH64)
shared_objects = $(aarch64_objects)
include make/linux.mk
