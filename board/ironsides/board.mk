# RK3399 under Linux: two Cortex-A72 and four Cortex-A53.
CXX_LINUX = $(CXX_AARCH64)
CXX_AARCH64 ?= aarch64-linux-gnu-g++
BINUTILS := aarch64-linux-gnu-
MACHINE := -mcpu=cortex-a72 -mno-outline-atomics
include make/linux.mk
