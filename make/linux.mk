# Boards under Linux: pirvsd, the device program, one static file. Included by board/<name>/board.mk,
# which says for which processor: CXX_LINUX, BINUTILS, MACHINE; LIBGPIOD, where its library lies;
# LIBS_LINUX, what its own sources need; and where the objects of core and modules come from that it
# shares with other boards: shared_objects(sources).
#
#   sources   *.cc below core, modules, bsp/linux, board/linux, board/$(BOARD), and drivers of chips
#             that Linux itself does not drive; no tests
#   pirvs-usb *.cc below board/usb, and what they need of core and bsp/linux
LINUX_SRC := $(filter-out %_test.cc %_bench.cc,\
  $(call find_cc,core modules bsp/linux board/linux board/$(BOARD))) \
  bsp/drivers/icm20602/icm20602.cc board/usb/usb_settings.cc
LINUX_SHARED := $(filter core/% modules/% bsp/drivers/%,$(LINUX_SRC))
LINUX_OBJ := $(patsubst %.cc,$(OUT)/obj/%.o,$(filter-out $(LINUX_SHARED),$(LINUX_SRC))) \
  $(call shared_objects,$(LINUX_SHARED)) $(VERSION_OBJ)

USB_SRC := $(filter-out %_test.cc,$(call find_cc,board/usb core/base core/config)) \
  $(addprefix bsp/linux/,assert.cc clock.cc console.cc system_calls.cc text_file.cc)
USB_OBJ := $(patsubst %.cc,$(OUT)/obj/%.o,$(filter-out core/%,$(USB_SRC))) \
  $(call shared_objects,$(filter core/%,$(USB_SRC)))

LINUX := $(MACHINE) -ffunction-sections -fdata-sections -fno-pic
LINUX_LINK := -static -no-pie -Wl,--gc-sections,--build-id=none
# board/linux/heap_watch.cc counts.
HEAP_WATCH := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc

all: $(OUT)/pirvsd $(OUT)/pirvs-usb ## build the device programs, build/BOARD/pirvsd and pirvs-usb

size: $(OUT)/pirvsd ## code, constants and static memory of the program
	@$(BINUTILS)size $<

# ---- build -------------------------------------------------------------------------------------
define compile_linux
@mkdir -p $(@D)
@echo "c++ $< ($(BOARD))"
@trap 'rm -f $@.$$$$' EXIT; \
  $(CXX_LINUX) $(COMMON) $(RELEASE) $(LINUX) $(BELOW_TOOLS) -MMD -MP -MF $@.$$$$.d -MT $@ \
  -c $< -o $@.$$$$ || { rm -f $@.$$$$.d; exit 1; }; mv $@.$$$$.d $(@:.o=.d); mv $@.$$$$ $@
endef
$(OUT)/obj/%.o: %.cc Makefile make/linux.mk board/$(BOARD)/board.mk | $(BUILD)/setup.stamp
	$(compile_linux)
$(VERSION_OBJ): $(OUT)/version.cc
	$(compile_linux)

$(OUT)/sources.list: FORCE
	@mkdir -p $(@D)
	@echo "$(LINUX_SRC) $(USB_SRC)" | cmp -s - $@ || echo "$(LINUX_SRC) $(USB_SRC)" > $@

$(OUT)/pirvsd: $(LINUX_OBJ) $(LIBGPIOD) $(OUT)/sources.list
	@echo "link $@"
	@$(CXX_LINUX) $(LINUX_LINK) $(HEAP_WATCH) $(LINUX_OBJ) $(LIBGPIOD) $(LIBS_LINUX) -o $@.$$$$ \
	  && mv $@.$$$$ $@

$(OUT)/pirvs-usb: $(USB_OBJ) $(OUT)/sources.list
	@echo "link $@"
	@$(CXX_LINUX) $(LINUX_LINK) $(USB_OBJ) -o $@.$$$$ && mv $@.$$$$ $@

# What plays a recording to pirvsd in its test, and what stands at its pins (make test-device).
FEEDER_SRC := tests/device/guest/feeder.cc bsp/replay/pack.cc bsp/replay/replay.cc \
  $(addprefix bsp/linux/,assert.cc clock.cc events.cc)
ROBOT_SRC := tests/device/guest/robot.cc
FEEDER_OBJ := $(FEEDER_SRC:%.cc=$(OUT)/obj/%.o)
ROBOT_OBJ := $(ROBOT_SRC:%.cc=$(OUT)/obj/%.o) $(OUT)/obj/bsp/linux/assert.o \
  $(call shared_objects,modules/stream/stream.cc $(filter core/base/% core/math/%,$(LINUX_SRC)))
$(BUILD)/device/feeder: $(FEEDER_OBJ)
$(BUILD)/device/robot: $(ROBOT_OBJ)
$(BUILD)/device/feeder $(BUILD)/device/robot:
	@mkdir -p $(@D)
	@$(CXX_LINUX) $(LINUX_LINK) $^ -o $@

# The PC at the other end of USB, in its test.
PEER_SRC := tests/device/guest/usb_peer.cc $(filter bsp/%,$(FEEDER_SRC))
PEER_OBJ := $(patsubst %.cc,$(OUT)/obj/%.o,$(PEER_SRC)) \
  $(call shared_objects,modules/output/pose_text.cc $(filter core/base/% core/math/%,$(LINUX_SRC)))
$(BUILD)/device/usb_peer: $(PEER_OBJ)
	@mkdir -p $(@D)
	@$(CXX_LINUX) $(LINUX_LINK) $(PEER_OBJ) -o $@

ifeq ($(filter help clean setup format,$(MAKECMDGOALS)),)
-include $(patsubst %.o,%.d,$(filter %.o,$(LINUX_OBJ) $(USB_OBJ) $(FEEDER_OBJ) $(ROBOT_OBJ) \
  $(PEER_OBJ)))
endif
