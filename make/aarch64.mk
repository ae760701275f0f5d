# Boards with AArch64 processors: their compiler, and the objects that are the same for all of them,
# compiled once into build/aarch64. Included by make/bare.mk and by the board.mk of boards under
# Linux.
CXX_AARCH64 ?= aarch64-linux-gnu-g++
BINUTILS := aarch64-linux-gnu-

# One code for both kinds of core of an RK3399. Frame pointers are what a fault report follows.
AARCH64 := -mcpu=cortex-a72 -mno-outline-atomics -fno-omit-frame-pointer -fno-stack-protector \
  -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections -fno-pic -fno-pie

# All are laid out for the sensors of board/bare/board_limits.h.
ifneq ($(wildcard board/$(BOARD)/board_limits.h),)
  $(error board/$(BOARD)/board_limits.h: boards that share objects share board/bare's)
endif

# aarch64_objects(sources)
aarch64_objects = $(patsubst %,$(BUILD)/aarch64/obj/%.o,$(basename $(1)))

# compile_aarch64(for whom, flags of all boards)
define compile_aarch64
@mkdir -p $(@D)
@echo "c++ $< ($(1))"
@trap 'rm -f $@.$$$$' EXIT; \
  $(CXX_AARCH64) $(2) $(RELEASE) $(AARCH64) $(BELOW_TOOLS) -MMD -MP -MF $@.$$$$.d -MT $@ \
  -c $< -o $@.$$$$ || { rm -f $@.$$$$.d; exit 1; }; mv $@.$$$$.d $(@:.o=.d); mv $@.$$$$ $@
endef
AARCH64_RULES := Makefile make/aarch64.mk
$(BUILD)/aarch64/obj/%.o: %.cc $(AARCH64_RULES) | $(BUILD)/setup.stamp
	$(call compile_aarch64,aarch64,$(subst -iquote board/$(BOARD) ,,$(COMMON)))
$(BUILD)/aarch64/obj/%.o: %.S $(AARCH64_RULES) | $(BUILD)/setup.stamp
	$(call compile_aarch64,aarch64,$(subst -iquote board/$(BOARD) ,,$(COMMON)))
