# A PC whose sensors are what a program feeds: libpirvs.so.0 (docs/api.md), over the host's library.
# Debian's compilers make objects that lie anywhere, so the host's go into a shared library as they
# are; but for those that reach into the C library's data or have a thread's own, bsp/linux's. These
# are compiled once more.
LIBRARY_SRC := $(wildcard board/library/*.cc) $(addprefix bsp/linux/,assert.cc clock.cc console.cc \
  cores.cc events.cc storage.cc system_calls.cc text_file.cc watchdog.cc)
LIBRARY_OBJ := $(LIBRARY_SRC:%.cc=$(OUT)/obj/%.o) $(VERSION_OBJ)
EXAMPLES := $(OUT)/poses-c $(OUT)/poses-cc
LIBRARY := $(OUT)/libpirvs.so.0
MARCH := -march=x86-64-v3
SHARED := -fPIC -fvisibility=hidden -ftls-model=initial-exec

all: $(LIBRARY) $(OUT)/libpirvs.so $(EXAMPLES) ## build the library, build/library/libpirvs.so.0, and its examples

# ---- build -------------------------------------------------------------------------------------
define compile
@mkdir -p $(@D)
@echo "c++ $< ($(BOARD))"
@trap 'rm -f $@.$$$$' EXIT; \
  $(CXX) $(COMMON) $(RELEASE) $(SHARED) $(BELOW_TOOLS) -MMD -MP -MF $@.$$$$.d -MT $@ \
  -c $< -o $@.$$$$ || { rm -f $@.$$$$.d; exit 1; }; mv $@.$$$$.d $(@:.o=.d); mv $@.$$$$ $@
endef
$(OUT)/obj/%.o: %.cc Makefile board/library/board.mk | $(BUILD)/setup.stamp
	$(compile)
$(VERSION_OBJ): $(OUT)/version.cc
	$(compile)

$(BUILD)/host/libpirvs.a: FORCE
	@$(MAKE) -s BOARD=host $@
$(LIBRARY): $(LIBRARY_OBJ) $(BUILD)/host/libpirvs.a board/library/exports.map
	@echo "link $@"
	@$(CXX) -shared -Wl,-soname,$(@F),--version-script=board/library/exports.map \
	  -Wl,-z,defs,-z,relro,--build-id=none $(LIBRARY_OBJ) $(BUILD)/host/libpirvs.a -o $@.$$$$ \
	  && mv $@.$$$$ $@
$(OUT)/libpirvs.so: $(LIBRARY)
	@ln -sf $(<F) $@

EXAMPLE_LINK := -Wall -Wextra -O1 -Iboard/library -L$(OUT) -Wl,-rpath,'$$ORIGIN'
$(OUT)/poses-c: board/library/examples/poses.c board/library/pirvs.h $(OUT)/libpirvs.so
	@gcc -std=c99 -pedantic $< $(EXAMPLE_LINK) -lpirvs -o $@.$$$$ && mv $@.$$$$ $@
$(OUT)/poses-cc: board/library/examples/poses.cc board/library/pirvs.h $(OUT)/libpirvs.so
	@$(CXX) -std=c++17 -pedantic $< $(EXAMPLE_LINK) -lpirvs -o $@.$$$$ && mv $@.$$$$ $@

ifeq ($(filter help clean setup format,$(MAKECMDGOALS)),)
-include $(LIBRARY_OBJ:.o=.d)
endif
