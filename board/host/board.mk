# A PC.
include make/host.mk
include make/package.mk
