# PIRVS: every command of the project. `make` alone lists them.
#
# Here is what all boards share. board/<name>/board.mk includes what its kind of board adds:
# make/host.mk, a PC with every tool and test; make/linux.mk, a device under Linux; make/bare.mk, no
# operating system.
# A source belongs to a set by its place and name alone; nothing is listed by hand.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
.SECONDARY:
MAKEFLAGS += --no-builtin-rules
# A make within make shares the jobs of the first.
ifeq ($(MAKELEVEL),0)
  MAKEFLAGS += -j$(shell nproc)
endif

BOARD ?= host
BUILD ?= build
OUT := $(BUILD)/$(BOARD)
BOARDS := $(patsubst board/%/board.mk,%,$(wildcard board/*/board.mk))
ifeq ($(filter $(BOARD),$(BOARDS)),)
  $(error no board/$(BOARD)/board.mk; boards: $(BOARDS))
endif
# boards_of(kind): those whose board.mk includes make/<kind>.mk.
boards_of = $(patsubst board/%/board.mk,%,$(sort $(shell grep -l 'make/$(1).mk' board/*/board.mk)))
BARE_BOARDS := $(call boards_of,bare)
LINUX_BOARDS := $(call boards_of,linux)

# ---- sources -----------------------------------------------------------------------------------
# find_cc(folders): every *.cc below those of the folders that exist.
find_cc = $(if $(wildcard $(1)),$(sort $(shell find $(wildcard $(1)) -name '*.cc' -not -name '.*')))

# ---- flags -------------------------------------------------------------------------------------
# COMMON goes into every object, tests and tools too: inline functions of Eigen and core must be the
# same code wherever the linker takes them from, or results would depend on the order of objects.
#   -ffp-contract=off, EIGEN_DONT_VECTORIZE   the same bits on x86-64 and AArch64
#   EIGEN_STACK_ALLOCATION_LIMIT              Eigen never calls malloc for a temporary
#   -iquote                                   board_limits.h: the board's own, or that of all bare
COMMON = -std=c++17 $(MARCH) -ffp-contract=off -fno-math-errno -Wall -Wextra \
  -DEIGEN_DONT_VECTORIZE -DEIGEN_STACK_ALLOCATION_LIMIT=18446744073709551615ul -DEIGEN_NO_IO \
  -I. -iquote board/$(BOARD) -iquote board/bare -isystem /usr/include/eigen3 \
  -ffile-prefix-map=$(CURDIR)/=
RELEASE := -O3 -g1
BELOW_TOOLS := -fno-exceptions -fno-rtti

# ---- commands ----------------------------------------------------------------------------------
.DEFAULT_GOAL := help
.PHONY: help all run size prof test test-unit test-system test-emulator test-device nightly fuzz \
  bench cases trust relocalization consistency eval paper check format setup clean FORCE

help: ## this list
	@echo "PIRVS: visual-inertial SLAM for a stereo camera and an IMU. Commands:"
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make \1\t\2/p' Makefile make/host.mk make/package.mk \
	  | expand -t 22
	@echo "Options: SEQ=recording ARGS='for pirvs run' (run), T=name (test, fuzz), K=name (bench),"
	@echo "  SAN=address|thread (test: that sanitizer everywhere), SECONDS=600 (fuzz),"
	@echo "  ARCH=native (all: for this machine's processor alone)"
	@echo "A device under Linux, BOARD=$(LINUX_BOARDS):"
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make BOARD=... \1\t\2/p' make/linux.mk | expand -t 28
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make BOARD=ironsides \1\t\2/p' make/image.mk | expand -t 32
	@echo "Without an operating system, BOARD=$(BARE_BOARDS):"
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make BOARD=... \1\t\2/p' make/bare.mk | expand -t 28
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make BOARD=rk3399-bare \1\t\2/p' \
	  board/rk3399-bare/board.mk | expand -t 36
	@echo "Options: SEQ=recording, DURATION=seconds of it, ARGS='words for the image'"

format: $(BUILD)/setup.stamp ## rewrite every source with clang-format
	@git ls-files -z --cached --others --exclude-standard '*.h' '*.cc' | xargs -0r clang-format -i

setup: ## install the packages of tools/setup/packages.txt that are missing
	@tools/setup/install
	@mkdir -p $(BUILD) && touch $(BUILD)/setup.stamp

clean: ## delete build/
	rm -rf $(BUILD)

$(BUILD)/setup.stamp: tools/setup/packages.txt tools/setup/install
	@tools/setup/install
	@mkdir -p $(BUILD) && touch $@

# The profiler's plugin for QEMU (docs/profiling.md).
$(BUILD)/prof/plugin.so: $(wildcard tools/prof/*.c tools/prof/*.h) | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	@echo "cc $<"
	@gcc -O2 -Wall -Wextra -shared -fPIC -fvisibility=hidden $(filter %.c,$^) -o $@.$$$$ \
	  && mv $@.$$$$ $@

# Which version this is: the one object of a board that depends on the revision. VERSION= instead.
REVISION := $(or $(VERSION),$(shell tools/setup/version))
VERSION_OBJ := $(OUT)/version.o
VERSION_TEXT = \#include "core/base/version.h"\nconst char pirvs::kVersion[] = "$(REVISION)";\n
$(OUT)/version.cc: FORCE
	@mkdir -p $(@D)
	@printf '$(VERSION_TEXT)' | cmp -s - $@ || printf '$(VERSION_TEXT)' > $@

include board/$(BOARD)/board.mk
