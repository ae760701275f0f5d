# A PC with cameras and an IMU: the device program as it runs on any.
CXX_LINUX = $(CXX)
BINUTILS :=
MACHINE := -march=x86-64-v3
include make/linux.mk
