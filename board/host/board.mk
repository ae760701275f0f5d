# A PC.
include make/host.mk
