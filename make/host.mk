# A PC: the program, its tools and all tests. Included by board/<name>/board.mk.
#
#   library   *.cc below core, modules, bsp/linux, bsp/replay, bsp/drivers, board/$(BOARD); of
#             board/linux and board/usb what is neither main nor wiring, of board/pc the JPEG
#             decoder, for their tests
#   tools     *.cc below tools; the file with main() becomes build/host/pirvs
#   tests     *_test.cc beside its source: address and UB sanitizers on
#   systems   *.cc below tests: whole-system replays, too slow for sanitizers, optimised build
#   fuzzers   *.cc below tests/fuzz: the parsers' targets; *_test.cc there replays the corpus
#   emulated  *.cc below tests/emulator: images without an operating system, run in QEMU
#   device    *.cc below tests/device: pirvsd under Debian's arm64 kernel in QEMU; guest/ holds what
#             runs there beside it
#   benches   *_bench.cc: Google Benchmark
# Unit tests have the address and UB sanitizers, system tests none. SAN=address or SAN=thread gives
# both kinds that one.
SAN ?=
OUT_SAN := $(BUILD)/$(BOARD)$(if $(filter thread,$(SAN)),-tsan,-asan)
OUT_TESTED := $(if $(SAN),$(OUT_SAN),$(OUT))
OUT_FUZZ := $(BUILD)/$(BOARD)-fuzz
ifneq ($(filter-out address thread,$(SAN)),)
  $(error SAN=$(SAN): there are address and thread)
endif

# ---- sources -----------------------------------------------------------------------------------
ALL_BELOW_TOOLS := $(call find_cc,core modules bsp/linux bsp/replay bsp/drivers \
  board/$(BOARD)) $(wildcard board/pc/jpeg*.cc) $(filter-out %/main.cc %/wiring.cc \
  %/heap_watch.cc,$(call find_cc,board/linux board/usb board/card))
ALL_TOOLS := $(call find_cc,tools)
ALL_FUZZ := $(call find_cc,tests/fuzz)
EMULATOR_SRC := $(call find_cc,tests/emulator)
DEVICE_SRC := $(filter-out tests/device/guest/%,$(call find_cc,tests/device))
ALL_SYSTEMS := $(filter-out $(ALL_FUZZ) $(EMULATOR_SRC) tests/device/%,$(call find_cc,tests))
EVERYTHING := $(ALL_BELOW_TOOLS) $(ALL_TOOLS) $(ALL_SYSTEMS) $(ALL_FUZZ) $(EMULATOR_SRC) \
  $(DEVICE_SRC)

BENCH_SRC := $(filter %_bench.cc,$(EVERYTHING))
TEST_SRC := $(filter %_test.cc,$(ALL_BELOW_TOOLS) $(ALL_TOOLS)) \
  $(filter-out %/libfuzzer.cc,$(ALL_FUZZ))
# Sanitizers bring a malloc of their own: nothing can be counted there.
SYSTEM_SRC := $(filter-out $(BENCH_SRC) $(if $(SAN),tests/heap_guard.cc tests/memory_test.cc \
  tests/library_test.cc),$(ALL_SYSTEMS))
LIB_SRC := $(filter-out %_test.cc %_bench.cc,$(ALL_BELOW_TOOLS))
TOOL_SRC := $(filter-out %_test.cc %_bench.cc,$(ALL_TOOLS))
MAIN_SRC := $(if $(TOOL_SRC),$(shell grep -lE '^int main\b' $(TOOL_SRC)))
TOOL_SRC_NO_MAIN := $(filter-out $(MAIN_SRC),$(TOOL_SRC))
# What no unit test reaches is not compiled with sanitizers: commands, and what they alone need.
UNREACHED := $(if $(SAN),,%_command.cc %_view.cc tools/convert/% tools/ros2/% \
  $(addprefix tools/view/,server.cc view.cc image_encoder.cc serial_commands.cc system_load.cc) \
  $(addprefix tools/run/,run.cc run_mcap.cc robot_output.cc) \
  $(addprefix tools/info/,image_turn.cc info_report.cc stereo_sense.cc) \
  $(addprefix tools/calib/,corner_input.cc flight_check.cc flight_points.cc))
# The parsers and the sensor door, and no more: clang compiles them a second time.
FUZZ_LIB_SRC := $(filter core/math/% core/camera/% core/config/% core/base/number.cc \
  core/base/text% modules/app/app_params.cc modules/app/intake.cc modules/calibration/% \
  board/linux/settings.cc board/linux/text_commands.cc board/linux/link_settings.cc \
  board/linux/endpoint_text.cc board/linux/serial_text.cc board/linux/gnss_settings.cc \
  board/usb/usb_settings.cc bsp/linux/tty.cc modules/door/% \
  modules/gnss/% modules/link/% modules/output/pose_feed.cc modules/health/% \
  modules/recorder/order_row.cc bsp/replay/% bsp/drivers/device_tree/% bsp/linux/assert.cc \
  bsp/linux/clock.cc \
  bsp/linux/console.cc bsp/linux/events.cc,$(LIB_SRC))
FUZZ_TOOL_SRC := $(filter-out %_test.cc,$(ALL_FUZZ)) $(filter-out %_command.cc,\
  $(filter tools/dataset/% tools/run/fault.cc tools/run/parameters.cc,$(TOOL_SRC)))

# ---- flags -------------------------------------------------------------------------------------
# What is shipped runs on every PC of the last ten years (AVX2). ARCH=native: for this machine's
# processor alone. Both give the same bytes.
ARCH ?= $(if $(filter x86_64,$(shell uname -m)),x86-64-v3,native)
MARCH := -march=$(ARCH)
comma := ,
# Not among the sanitizers: null (address sees it as well), alignment and object-size, which double
# the time to compile Eigen and forbid nothing that our chips cannot do.
SANITIZERS := $(if $(filter thread,$(SAN)),-fsanitize=thread,-fsanitize=address$(comma)undefined \
  -fno-sanitize=null$(comma)alignment$(comma)object-size)
SANITIZE := -O1 -g1 -fno-omit-frame-pointer $(SANITIZERS) -fno-sanitize-recover=all
FUZZER := -O1 -g1 -fno-omit-frame-pointer -fno-sanitize-recover=all
CLANGXX ?= clang++

TOOLS := -isystem /usr/include/opencv4
# What idlc makes of ROS's types.
IDL := $(BUILD)/idl

LIBS_TOOLS := -lopencv_calib3d -lopencv_features2d -lopencv_video -lopencv_videoio -lopencv_imgcodecs \
  -lopencv_imgproc -lopencv_core -lyaml-cpp -lsqlite3 -llz4 -lzstd -lbz2 -lgpiod -lddsc \
  -lwebsockets -lceres -lglog -lapriltag -lpthread
LIBS_TEST := -lgtest_main -lgtest $(LIBS_TOOLS) -ljpeg
LIBS_BENCH := -lbenchmark_main -lbenchmark $(LIBS_TOOLS)

# ---- commands ----------------------------------------------------------------------------------
all: $(OUT)/pirvs view ## build the program, build/host/pirvs, and the page of `pirvs view`

# The page is one file, build/view/view.html, which the program finds beside itself. Its libraries are
# fetched once. Without npm there is no page, and all else is there.
.PHONY: view
VIEW_PAGE := $(BUILD)/view/view.html
VIEW_MODULES := $(BUILD)/view/node_modules/.package-lock.json
view: $(VIEW_PAGE) ## build the page of `pirvs view` alone; needs npm
$(VIEW_MODULES): tools/view/page/package.json tools/view/page/package-lock.json | $(BUILD)/setup.stamp
	@mkdir -p $(BUILD)/view && cp $^ $(BUILD)/view
	-@cd $(BUILD)/view && npm ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 \
	  --loglevel=error >/dev/null && touch node_modules/.package-lock.json
$(VIEW_PAGE): $(wildcard tools/view/page/*) $(VIEW_MODULES)
	@echo "page $@"
	@node tools/view/page/build.mjs $(@D) || echo "make: no page for pirvs view: it needs npm and, once, a network"

SIM := $(BUILD)/run/sim
SEQ ?= $(SIM)
SIMULATED := $(if $(filter $(SIM),$(SEQ)),$(SIM).done)
run: $(OUT)/pirvs $(SIMULATED) ## SLAM on a simulated recording, or SEQ=path to an ASL folder
	@mkdir -p $(BUILD)/run
	@echo "$(OUT)/pirvs run $(SEQ) --out $(BUILD)/run --force $(ARGS)"
	@status=0; $(OUT)/pirvs run $(SEQ) --out $(BUILD)/run --force $(ARGS) || status=$$?; \
	  [ ! -e $(BUILD)/run/report.html ] || echo "report: $(CURDIR)/$(BUILD)/run/report.html"; \
	  exit $$status

# The stamp is written last, so an interrupted simulation is done again.
$(SIM).done: | $(OUT)/pirvs
	@rm -rf $(SIM) && mkdir -p $(dir $(SIM))
	$(OUT)/pirvs sim --out $(SIM)
	@touch $@

# T=name runs the tests whose full name (suite.test) contains it. Results for machines are left in
# build/test/*.json.
FILTER_ARG := $(if $(T),--filter '*$(T)*')
test: test-unit test-system test-emulator ## every test; T=name those whose name contains it

SAN_OPTIONS := UBSAN_OPTIONS=print_stacktrace=1 TSAN_OPTIONS=suppressions=tests/tsan.supp
test-unit: $(OUT_SAN)/tests ## unit tests alone, sanitizers on
	@mkdir -p $(BUILD)/test && rm -f $(BUILD)/test/unit.json
	$(SAN_OPTIONS) tests/suites $(OUT_SAN)/tests --brief \
	  --json $(BUILD)/test/unit.json $(FILTER_ARG)

# The other side of the robot's link, which shares no code with ours; fetched once. Without it, the
# tests that need it fail by name.
LINK_CLIENT := $(BUILD)/link/node_modules/.package-lock.json
$(LINK_CLIENT): tests/link/package.json tests/link/package-lock.json | $(BUILD)/setup.stamp
	@mkdir -p $(BUILD)/link && cp $^ $(BUILD)/link
	-@cd $(BUILD)/link && npm ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error >/dev/null
	-@touch $@

# Writers of logs, fetched once, too.
LOG_WRITER := $(BUILD)/logs/node_modules/.package-lock.json
$(LOG_WRITER): tests/logs/package.json tests/logs/package-lock.json | $(BUILD)/setup.stamp
	@mkdir -p $(BUILD)/logs && cp $^ $(BUILD)/logs
	-@cd $(BUILD)/logs && npm ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error >/dev/null
	-@touch $@

# What drives a browser, fetched once, too.
VIEW_DRIVER := $(BUILD)/view-test/node_modules/.package-lock.json
$(VIEW_DRIVER): tests/view/package.json tests/view/package-lock.json | $(BUILD)/setup.stamp
	@mkdir -p $(BUILD)/view-test && cp $^ $(BUILD)/view-test
	-@cd $(BUILD)/view-test && npm ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error >/dev/null
	-@touch $@

# A reader of our topics that shares ROS's definitions of them with ours, and no more.
ROS2_READER := $(BUILD)/ros2/reader
$(ROS2_READER): tests/ros2/reader.c $(IDL)/Messages.c
	@mkdir -p $(@D)
	@gcc -O1 -Wall -Wextra -I$(IDL) $^ -lddsc -o $@

ONE_BY_ONE := $(if $(filter test,$(MAKECMDGOALS)),test-unit)
test-system: $(OUT_TESTED)/system_tests $(OUT)/pirvs $(LINK_CLIENT) $(LOG_WRITER) $(ROS2_READER) $(VIEW_PAGE) $(VIEW_DRIVER) $(ONE_BY_ONE) ## whole-system replays alone
	@$(if $(SAN),,$(MAKE) -s BOARD=library all)
	@mkdir -p $(BUILD)/test && rm -f $(BUILD)/test/system.json
	PIRVS_BUILD=$(BUILD) $(SAN_OPTIONS) tests/suites $(OUT_TESTED)/system_tests \
	  --json $(BUILD)/test/system.json $(FILTER_ARG)

# What people reported, if ../shared is there; CASES=01,04 some of them.
CASES ?=
cases: $(OUT)/pirvs ## other people's files: how each case behaves and should
	@tools/cases/cases --pirvs $(OUT)/pirvs $(if $(CASES),--only $(CASES)) $(ARGS)

# Draws its recordings once, 3 GB. T=name those whose name contains it, T=kind=5 a kind.
trust: $(OUT)/pirvs ## is the pose doubted where it is wrong? a table, and a page; T=name some
	@tools/trust/trust --pirvs $(OUT)/pirvs --out $(BUILD)/trust $(if $(T),--only $(T)) $(ARGS)

# Rooms of Monday on Tuesday (docs/maps.md).
relocalization: $(OUT)/pirvs ## is a saved map found again, and no other? 20 starts, and 20 elsewhere
	@tools/relocalization/relocalization --pirvs $(OUT)/pirvs --out $(BUILD)/relocalization $(ARGS)

# Golden replays are system tests too. Their values are renewed on purpose alone.
golden: $(OUT_TESTED)/system_tests ## replays against stored digits; RENEW=1 rewrites tests/golden
	PIRVS_RENEW=$(RENEW) $(OUT_TESTED)/system_tests --gtest_brief=1 --gtest_filter='golden*'

# The paper's data sets, as far as they are there (docs/evaluation.md).
paper: $(OUT)/pirvs ## the paper's tables: EUROC=DIR PENNCOSYVIO=DIR TUMVI=DIR
	@tools/paper/paper --pirvs $(OUT)/pirvs --out $(BUILD)/paper $(if $(EUROC),--euroc $(EUROC)) \
	  $(if $(PENNCOSYVIO),--penncosyvio $(PENNCOSYVIO)) $(if $(TUMVI),--tumvi $(TUMVI)) $(ARGS)

# New inputs gather in build/fuzz/NAME; worth keeping: -merge=1 them into tests/fuzz/corpus/NAME.
SECONDS ?= 600
fuzz: $(OUT_FUZZ)/fuzz ## throw bytes at a parser: T=name SECONDS=600
	@mkdir -p $(BUILD)/fuzz/$(T)
	PIRVS_FUZZ=$(T) $(OUT_FUZZ)/fuzz -max_total_time=$(SECONDS) -max_len=4096 -timeout=20 \
	  -print_final_stats=1 -artifact_prefix=$(BUILD)/fuzz/ $(BUILD)/fuzz/$(T) tests/fuzz/corpus/$(T)

PROF_PLUGIN := $(BUILD)/prof/plugin.so
IN_TURN := $(if $(ONE_BY_ONE),test-system)
test-emulator: $(OUT)/emulator_tests $(OUT)/pirvs $(PROF_PLUGIN) $(IN_TURN) ## images in the emulator alone
	@$(MAKE) -s BOARD=qemu-virt all
	@$(MAKE) -s BOARD=rk3399-bare all firmware
	@mkdir -p $(BUILD)/test && rm -f $(BUILD)/test/emulator.json
	PIRVS_BUILD=$(BUILD) tests/suites $(OUT)/emulator_tests \
	  --json $(BUILD)/test/emulator.json $(FILTER_ARG)

# Debian's kernel is fetched once, 120 MB; `make clean` forgets it.
DEVICE := $(BUILD)/device
test-device: $(OUT)/device_tests $(OUT)/pirvs $(DEVICE)/release $(DEVICE)/modules/dummy_hcd.c ## pirvsd under an arm64 kernel alone
	@$(MAKE) -s BOARD=ironsides all $(addprefix $(DEVICE)/,feeder robot usb_peer)
	@$(MAKE) -s BOARD=ironsides image $(DEVICE)/first_pose
	@tools/device/build_modules $(DEVICE) tests/device/guest $(DEVICE)/modules
	@mkdir -p $(BUILD)/test && rm -f $(addprefix $(BUILD)/test/,device.json long.json card.json)
	@$(if $(T),$(call device_tests,device,*$(T)*),$(DEVICE_AND_CARD))
# device_tests(name of the results, filter)
device_tests = PIRVS_BUILD=$(BUILD) $(OUT)/device_tests --gtest_filter='$(2)' \
  --gtest_output=json:$(BUILD)/test/$(1).json
# Two machines of one processor each at a time, then those of the card, which have two: beside more,
# the clocks of those that count instructions leap. The long ones are as long as all others.
LONG := usb.*:device_load.*
define DEVICE_AND_CARD
$(call device_tests,long,$(LONG)) > $(BUILD)/test/long.txt 2>&1 & long=$$!; \
  status=0; $(call device_tests,device,-image.*:$(LONG)) || status=1; \
  wait $$long || status=1; cat $(BUILD)/test/long.txt; \
  $(call device_tests,card,image.*) || status=1; exit $$status
endef
$(DEVICE)/release: tools/device/fetch_kernel | $(BUILD)/setup.stamp
	@tools/device/fetch_kernel $(DEVICE)
# A USB device controller and a host in one, out of the kernel's source, 140 MB, fetched once.
$(DEVICE)/source/dummy_hcd.c: tools/device/fetch_source $(DEVICE)/release
	@tools/device/fetch_source $(DEVICE) $(@D) drivers/usb/gadget/udc/dummy_hcd.c
$(DEVICE)/modules/dummy_hcd.c: tests/device/guest/dummy_hcd.patch $(DEVICE)/source/dummy_hcd.c
	@mkdir -p $(@D)
	@patch -s -o $@ $(DEVICE)/source/dummy_hcd.c $<

# All that is fetched besides packages of this machine, 470 MB; else each comes when it is wanted.
.PHONY: fetch
fetch: $(LINK_CLIENT) $(LOG_WRITER) $(VIEW_MODULES) $(VIEW_DRIVER) $(DEVICE)/release $(DEVICE)/source/dummy_hcd.c
	@$(MAKE) -s BOARD=ironsides fetch

CUTS ?= 200
nightly: ## what takes too long for every day: clang-tidy of all, 200 power cuts, 10 minutes of all sensors
	@$(MAKE) check people-test
	@$(MAKE) reproducible
	@PIRVS_NIGHTLY=1 PIRVS_PICTURES=docs/pictures $(MAKE) test-system T=view.
	@CUTS=$(CUTS) $(MAKE) test-device T=power_cuts
	@FAILURES=each $(MAKE) test-device T=versions_that_fail
	@PIRVS_LOAD_SECONDS=600 $(MAKE) test-device T=device_load

bench: $(OUT)/bench ## every kernel: reference, NEON, OpenCV where it has one; K=name one
	$(OUT)/bench --benchmark_filter='$(if $(K),$(K),.)' --benchmark_counters_tabular=true

# 50 flights: half an hour of one core.
FLIGHTS ?= 50
consistency: $(OUT)/pirvs ## does the covariance contain the error? FLIGHTS=50 simulated ones
	@tools/consistency/consistency --pirvs $(OUT)/pirvs --out $(BUILD)/consistency \
	  --flights $(FLIGHTS) $(ARGS)

# Recordings are found by PIRVS_DATA and EVAL_HYBRID, or drawn once into EVAL_DATA
# (docs/evaluation.md). BASE: build/eval of another revision, or another program.
eval: $(OUT)/pirvs ## a set to judge by: FAST=1 some rows once, BASE=DIR against that result
	@tools/judge/judge --pirvs $(OUT)/pirvs --out $(BUILD)/eval $(if $(FAST),--fast) \
	  $(if $(BASE),--base $(BASE)) $(ARGS)

COMMITS ?= 0
check: $(BUILD)/setup.stamp $(OUT)/libpirvs.a ## format, names, layers, no-heap, function length
	@for board in $(BARE_BOARDS) $(LINUX_BOARDS); do $(MAKE) -s BOARD=$$board all size; done
	@tools/check/run --build $(BUILD) --commits $(COMMITS) --objects $(OUT)/obj \
	  $(LINUX_BOARDS:%=--objects $(BUILD)/%/obj) $(BARE_BOARDS:%=--image $(BUILD)/%/pirvs.elf)

# ---- build -------------------------------------------------------------------------------------
# objects(tree, sources)
objects = $(patsubst %.cc,$(1)/obj/%.o,$(2))

$(IDL)/Messages.c: tools/ros2/Messages.idl | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	@idlc -o $(@D) $<
$(IDL)/Messages.h: $(IDL)/Messages.c
$(IDL)/Messages.o: $(IDL)/Messages.c
	@gcc -O1 -c $< -o $@
IDL_USERS := $(OUT)/obj/tools/ros2/topics.o $(OUT_SAN)/obj/tools/ros2/topics.o
$(IDL_USERS): $(IDL)/Messages.h

LIB_OBJ := $(call objects,$(OUT),$(LIB_SRC))
LIB_OBJ_SAN := $(call objects,$(OUT_SAN),$(LIB_SRC))
TOOL_OBJ := $(call objects,$(OUT),$(TOOL_SRC_NO_MAIN))
TOOL_OBJ_SAN := $(call objects,$(OUT_SAN),$(filter-out $(UNREACHED),$(TOOL_SRC_NO_MAIN)))
MAIN_OBJ := $(call objects,$(OUT),$(MAIN_SRC))
TEST_OBJ := $(call objects,$(OUT_SAN),$(TEST_SRC))
SYSTEM_OBJ := $(call objects,$(OUT_TESTED),$(SYSTEM_SRC))
FUZZ_LIB_OBJ := $(call objects,$(OUT_FUZZ),$(FUZZ_LIB_SRC))
FUZZ_TOOL_OBJ := $(call objects,$(OUT_FUZZ),$(FUZZ_TOOL_SRC))
BENCH_OBJ := $(call objects,$(OUT),$(BENCH_SRC))
EMULATOR_OBJ := $(call objects,$(OUT),$(EMULATOR_SRC))
DEVICE_OBJ := $(call objects,$(OUT),$(DEVICE_SRC))
# What replays and recordings need in both test programs.
SYSTEM_SHARED := $(call objects,$(OUT),$(filter-out %_test.cc %/heap_guard.cc,$(ALL_SYSTEMS)))

$(LIB_OBJ) $(LIB_OBJ_SAN) $(FUZZ_LIB_OBJ) $(VERSION_OBJ): KIND := $(BELOW_TOOLS)
$(TOOL_OBJ) $(TOOL_OBJ_SAN) $(MAIN_OBJ) $(TEST_OBJ) $(SYSTEM_OBJ) $(BENCH_OBJ) $(FUZZ_TOOL_OBJ) \
  $(EMULATOR_OBJ) $(DEVICE_OBJ) $(SYSTEM_SHARED): KIND := $(TOOLS)
$(IDL_USERS): KIND += -isystem $(IDL)
# clang: sanitized objects take it half of GCC's time, and another compiler's warnings are read.
$(OUT_SAN)/% $(OUT_FUZZ)/%: override CXX := $(CLANGXX)

# What makes an object anew besides its sources: other flags.
$(BUILD)/arch: FORCE
	@mkdir -p $(@D)
	@echo "$(ARCH)" | cmp -s - $@ || echo "$(ARCH)" > $@
RULES := Makefile make/host.mk $(BUILD)/arch

# An object appears whole or not at all ($$$$ is the shell's pid): two makes may share one build/.
define compile
@mkdir -p $(@D)
@echo "c++ $<$(if $(filter $(OUT_SAN)/%,$@), (sanitized))"
@trap 'rm -f $@.$$$$' EXIT; \
  $(CXX) $(COMMON) $(1) $(KIND) -MMD -MP -MF $@.$$$$.d -MT $@ -c $< -o $@.$$$$ \
  || { rm -f $@.$$$$.d; exit 1; }; mv $@.$$$$.d $(@:.o=.d); mv $@.$$$$ $@
endef
$(OUT)/obj/%.o: %.cc $(RULES) | $(BUILD)/setup.stamp
	$(call compile,$(RELEASE))
$(OUT_SAN)/obj/%.o: %.cc $(RULES) | $(BUILD)/setup.stamp
	$(call compile,$(SANITIZE))
$(OUT_FUZZ)/obj/%.o: %.cc $(RULES) | $(BUILD)/setup.stamp
	$(call compile,$(FUZZER) -fsanitize=fuzzer-no-link$(comma)address$(comma)undefined)

$(VERSION_OBJ): $(OUT)/version.cc
	$(call compile,$(RELEASE))

# The list changes only when a source comes or goes; then everything is linked again.
$(BUILD)/sources.list: FORCE
	@mkdir -p $(@D)
	@echo "$(EVERYTHING)" | cmp -s - $@ || echo "$(EVERYTHING)" > $@

define archive
@rm -f $@.$$$$ && ar rcsD $@.$$$$ $(filter %.o,$^) && mv $@.$$$$ $@
endef
$(OUT)/libpirvs.a: $(LIB_OBJ) $(BUILD)/sources.list | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	$(archive)
$(OUT_SAN)/libpirvs.a: $(LIB_OBJ_SAN) $(BUILD)/sources.list | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	$(archive)
$(OUT)/libtools.a: $(TOOL_OBJ) $(IDL)/Messages.o $(BUILD)/sources.list | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	$(archive)
$(OUT_SAN)/libtools.a: $(TOOL_OBJ_SAN) $(IDL)/Messages.o $(BUILD)/sources.list | $(BUILD)/setup.stamp
	@mkdir -p $(@D)
	$(archive)

# Another revision alone links no test anew. A build id would tell folders apart: it is made of the
# debug information, too, which names them.
define link
@mkdir -p $(@D)
@echo "link $@"
@$(CXX) $(1) -Wl,--build-id=none $(filter %.o,$(filter-out $(VERSION_OBJ),$^)) $(VERSION_OBJ) \
  $(filter %.a,$^) $(2) -o $@.$$$$ && mv $@.$$$$ $@
endef
$(OUT)/pirvs: $(MAIN_OBJ) $(OUT)/libtools.a $(OUT)/libpirvs.a $(VERSION_OBJ)
	$(call link,$(RELEASE),$(LIBS_TOOLS))
$(OUT_SAN)/tests: $(TEST_OBJ) $(OUT_SAN)/libtools.a $(OUT_SAN)/libpirvs.a | $(VERSION_OBJ)
	$(call link,$(SANITIZE),$(LIBS_TEST))
$(OUT_TESTED)/system_tests: $(SYSTEM_OBJ) $(OUT_TESTED)/libtools.a $(OUT_TESTED)/libpirvs.a | $(VERSION_OBJ)
	$(call link,$(if $(SAN),$(SANITIZE),$(RELEASE)),$(LIBS_TEST))
$(OUT_FUZZ)/fuzz: $(FUZZ_LIB_OBJ) $(FUZZ_TOOL_OBJ) | $(VERSION_OBJ)
	$(call link,-fsanitize=fuzzer$(comma)address$(comma)undefined,$(LIBS_TOOLS))
$(OUT)/emulator_tests: $(EMULATOR_OBJ) $(SYSTEM_SHARED) $(OUT)/libtools.a $(OUT)/libpirvs.a \
  | $(VERSION_OBJ)
	$(call link,$(RELEASE),$(LIBS_TEST))
$(OUT)/device_tests: $(DEVICE_OBJ) $(SYSTEM_SHARED) $(OUT)/libtools.a $(OUT)/libpirvs.a \
  | $(VERSION_OBJ)
	$(call link,$(RELEASE),$(LIBS_TEST))
$(OUT)/bench: $(BENCH_OBJ) $(OUT)/libtools.a $(OUT)/libpirvs.a | $(VERSION_OBJ)
	$(call link,$(RELEASE),$(LIBS_BENCH))

ifeq ($(filter help clean setup format,$(MAKECMDGOALS)),)
-include $(patsubst %.o,%.d,$(LIB_OBJ) $(LIB_OBJ_SAN) $(TOOL_OBJ) $(TOOL_OBJ_SAN) $(MAIN_OBJ) \
  $(TEST_OBJ) $(SYSTEM_OBJ) $(BENCH_OBJ) $(FUZZ_LIB_OBJ) $(FUZZ_TOOL_OBJ) $(EMULATOR_OBJ) \
  $(DEVICE_OBJ))
endif
