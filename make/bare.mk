# Boards without an operating system: cross-built, one linker script each, no C library but its
# memcpy and the like. Included by board/<name>/board.mk.
#
#   library   *.cc and *.S below core, modules, bsp/bare, bsp/drivers, bsp/replay, board/bare,
#             board/$(BOARD); no tests, no emulated chips
include make/aarch64.mk
PICOLIBC := /usr/lib/picolibc/aarch64-linux-gnu/lib
LINKER_SCRIPT := linker/$(BOARD).ld

BARE_FOLDERS := core modules bsp/bare bsp/drivers bsp/replay board/bare board/$(BOARD)
HOST_ONLY := %_test.cc %_bench.cc %_emulator.cc bsp/drivers/emulated/%
BARE_SRC := $(filter-out $(HOST_ONLY),$(call find_cc,$(BARE_FOLDERS))) \
  $(sort $(shell find $(BARE_FOLDERS) -name '*.S'))
BARE_OBJ := $(call aarch64_objects,$(filter-out board/$(BOARD)/%,$(BARE_SRC))) \
  $(patsubst %,$(OUT)/obj/%.o,$(basename $(filter board/$(BOARD)/%,$(BARE_SRC)))) \
  $(VERSION_OBJ)

# memset and memcpy themselves: no loop of theirs may become a call of them.
$(BUILD)/aarch64/obj/core/base/bytes.o: AARCH64 += -fno-tree-loop-distribute-patterns
BARE_LINK := -nostdlib -nostartfiles -static -no-pie -T $(LINKER_SCRIPT) -L. \
  -Wl,--gc-sections,--build-id=none,-z,max-page-size=4096,--no-warn-rwx-segments,--fatal-warnings

all: $(OUT)/pirvs.elf $(OUT)/pirvs.bin ## build the image: pirvs.elf with names, pirvs.bin to load

size: $(OUT)/pirvs.elf ## code, constants, stacks, pools of the image
	@tools/size/size $<

# The packed recording lies beside the results: build/run-BOARD.
RUN := $(BUILD)/run-$(BOARD)
SIM := $(BUILD)/run/sim
SEQ ?= $(SIM)
DURATION ?= 5
run: $(OUT)/pirvs.bin ## SLAM in the emulator, on a simulated recording or SEQ=path
	@$(MAKE) -s BOARD=host all $(if $(filter $(SIM),$(SEQ)),$(SIM).done)
	@mkdir -p $(RUN)
	@tools/emulator/compare --image $(OUT)/pirvs.bin --pirvs $(BUILD)/host/pirvs --out $(RUN) \
	  --duration $(DURATION) $(SEQ) $(ARGS)

# The same image in the emulator, watched by the profiler's plugin: build/prof-BOARD.
PROF := $(BUILD)/prof-$(BOARD)
define profile
+@$(MAKE) -s BOARD=host all $(if $(filter $(SIM),$(SEQ)),$(SIM).done)
@mkdir -p $(PROF)
@$(BUILD)/host/pirvs pack $(SEQ) --out $(PROF)/recording.pack --duration $(DURATION)
@tools/prof/profile --elf $(OUT)/pirvs.elf --plugin $(BUILD)/prof/plugin.so --out $(PROF) $(1) -- \
  tools/emulator/run --image $(OUT)/pirvs.bin --out $(PROF) --recording $(PROF)/recording.pack \
  --timeout 7200 '--extra=-plugin {plugin}' $(2) $(ARGS)
endef
prof: $(OUT)/pirvs.bin $(BUILD)/prof/plugin.so ## Table II in instructions and estimated cycles; prof.json
	$(call profile,,profile)
bench: $(OUT)/pirvs.bin $(BUILD)/prof/plugin.so ## single kernels against their goals; K=name one
	$(call profile,--bench $(K),bench)

# ---- build -------------------------------------------------------------------------------------
$(OUT)/obj/%.o: %.cc $(AARCH64_RULES) | $(BUILD)/setup.stamp
	$(call compile_aarch64,$(BOARD),$(COMMON))
$(OUT)/obj/%.o: %.S $(AARCH64_RULES) | $(BUILD)/setup.stamp
	$(call compile_aarch64,$(BOARD),$(COMMON))

$(VERSION_OBJ): $(OUT)/version.cc
	$(call compile_aarch64,$(BOARD),$(COMMON))

$(OUT)/sources.list: FORCE
	@mkdir -p $(@D)
	@echo "$(BARE_SRC)" | cmp -s - $@ || echo "$(BARE_SRC)" > $@

$(OUT)/pirvs.elf: $(BARE_OBJ) $(OUT)/sources.list $(LINKER_SCRIPT) linker/bare.ld
	@echo "link $@"
	@$(CXX_AARCH64) $(BARE_LINK) $(BARE_OBJ) -L$(PICOLIBC) -Wl,--start-group -lc -lgcc \
	  -Wl,--end-group -Wl,-Map,$(OUT)/pirvs.map -o $@.$$$$ && mv $@.$$$$ $@
$(OUT)/pirvs.bin: $(OUT)/pirvs.elf
	@$(BINUTILS)objcopy -O binary $< $@

ifeq ($(filter help clean setup format,$(MAKECMDGOALS)),)
-include $(BARE_OBJ:.o=.d)
endif
