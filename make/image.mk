# The card of a board under Linux: U-Boot, two slots with kernel and root, what a person edits,
# recordings. Included by board/<name>/board.mk, whose folder image/ says what is on it. Needs:
# UBOOT, Debian's U-Boot; DTB, the device tree, Debian's or a file. Nothing here needs root.
#
# Options: CALIBRATION=calibration.cfg of the device, onto the card; VERSION=name; KEY= and CERT=,
# who signs updates, and whose updates the device takes.
CONTENT := board/$(BOARD)/image
IMAGE_KERNEL := $(BUILD)/device
FIRMWARE := $(BUILD)/uboot/usr/lib/u-boot/$(UBOOT)
DEBIAN_ROOT := $(BUILD)/debian/$(BOARD).tar
CARD := $(OUT)/card.img
SLOT := $(OUT)/slot
SLOT_FILES := $(SLOT)/kernel.fit $(SLOT)/root.squashfs
KEYS := $(OUT)/keys
KEY ?= $(KEYS)/key.pem
CERT ?= $(KEYS)/cert.pem
EPOCH := $(shell git log -1 --format=%ct)
VERSION ?= $(subst ~,.,$(subst +,.,$(REVISION)))
COMPATIBLE := pirvs-$(BOARD)-$(UBOOT)
BUNDLE := $(OUT)/pirvs-$(VERSION).raucb
CALIBRATION ?=
ZSTD_LEVEL ?= 19
CARD_FILES := $(if $(CALIBRATION),calibration.cfg=$(CALIBRATION))

.PHONY: image bundle flash fetch
fetch: $(DEBIAN_ROOT) $(FIRMWARE)/idbloader.img $(LIBGPIOD)

image: $(SLOT_FILES) $(FIRMWARE)/idbloader.img ## card.img for SD or eMMC; UBOOT=board DTB=file CALIBRATION=file
	@tools/image/build_card --content $(CONTENT) --slot $(SLOT) --time $(EPOCH) --out $(CARD) \
	  --firmware $(FIRMWARE) $(CARD_FILES)
	@tools/image/bill --image $(CARD) --name $(COMPATIBLE) --version $(REVISION) --time $(EPOCH) \
	  --debian $(DEBIAN_ROOT) --packages $(BUILD)/uboot/packages --packages $(IMAGE_KERNEL)/root/packages \
	  $(addprefix --static ,libc6-dev-arm64-cross libstdc++-12-dev-arm64-cross \
	  libgcc-12-dev-arm64-cross libgpiod-dev libeigen3-dev) --compiler g++-12-aarch64-linux-gnu

bundle: $(SLOT_FILES) ## the same version as a signed update, for `pirvs update`; KEY= CERT= sign it
	@tools/image/build_bundle --slot $(SLOT) --compatible $(COMPATIBLE) --version $(VERSION) \
	  --key $(KEY) --cert $(CERT) --out $(BUNDLE)

flash: ## write the card: DEV=/dev/sdX
	@tools/image/flash $(CARD) $(DEV)

# ---- build -------------------------------------------------------------------------------------
# Programs of the card beside pirvsd.
CARD_COMMON := board/card/slot_state.cc bsp/linux/assert.cc
CARD_SRC := board/card/main.cc board/card/partition_table.cc $(CARD_COMMON)
RECEIVE_SRC := board/card/receive/main.cc board/card/receive/lines.cc $(CARD_COMMON)
CARD_OBJ := $(CARD_SRC:%.cc=$(OUT)/obj/%.o) $(call shared_objects,core/base/text.cc)
RECEIVE_OBJ := $(RECEIVE_SRC:%.cc=$(OUT)/obj/%.o) $(call shared_objects,core/base/text.cc)
$(OUT)/pirvs-card: $(CARD_OBJ)
$(OUT)/pirvs-receive: $(RECEIVE_OBJ)
$(OUT)/pirvs-card $(OUT)/pirvs-receive:
	@echo "link $@"
	@$(CXX_LINUX) $(LINUX_LINK) $^ -o $@.$$$$ && mv $@.$$$$ $@

# What says in the card's test when the first pose came (make test-device).
FIRST_POSE_OBJ := $(OUT)/obj/tests/device/guest/first_pose.o
$(BUILD)/device/first_pose: $(FIRST_POSE_OBJ)
	@mkdir -p $(@D)
	@$(CXX_LINUX) $(LINUX_LINK) $< -o $@

# What a slot holds. Programs without symbols: build/BOARD/pirvsd keeps them.
DEVICE_PROGRAMS := pirvsd pirvs-usb pirvs-card pirvs-receive
SLOT_PROGRAMS := $(DEVICE_PROGRAMS:%=$(SLOT)/bin/%)
$(SLOT)/bin/%: $(OUT)/%
	@mkdir -p $(@D)
	@$(BINUTILS)strip $< -o $@

$(SLOT)/kernel.fit: $(CONTENT)/init $(CONTENT)/slot.its $(CONTENT)/modules.initramfs \
  tools/image/build_kernel tools/image/kernel_modules.py $(IMAGE_KERNEL)/release $(OUT)/slot.options
	@mkdir -p $(@D)
	@tools/image/build_kernel --kernel $(IMAGE_KERNEL) --content $(CONTENT) --dtb $(DTB) --out $@

$(SLOT)/root.squashfs: $(SLOT_PROGRAMS) $(DEBIAN_ROOT) $(IMAGE_KERNEL)/release $(CERT) \
  $(OUT)/slot.options $(shell find $(CONTENT) -type f) tools/image/build_root
	@tools/image/build_root --debian $(DEBIAN_ROOT) --kernel $(IMAGE_KERNEL) --content $(CONTENT) \
	  --version $(VERSION) --compatible $(COMPATIBLE) --time $(EPOCH) --level $(ZSTD_LEVEL) \
	  --out $@ /etc/rauc/keyring.pem=$(CERT) \
	  $(foreach path,$(SLOT_PROGRAMS),/usr/bin/$(notdir $(path))=$(path))

SLOT_OPTIONS := $(VERSION) $(COMPATIBLE) $(DTB) $(EPOCH) $(ZSTD_LEVEL) $(CERT)
$(OUT)/slot.options: FORCE
	@mkdir -p $(@D)
	@echo "$(SLOT_OPTIONS)" | cmp -s - $@ || echo "$(SLOT_OPTIONS)" > $@

$(DEBIAN_ROOT): $(CONTENT)/packages.txt tools/image/fetch_root | $(BUILD)/setup.stamp
	@tools/image/fetch_root $< $@

$(IMAGE_KERNEL)/release: tools/device/fetch_kernel | $(BUILD)/setup.stamp
	@tools/device/fetch_kernel $(IMAGE_KERNEL)

$(FIRMWARE)/idbloader.img: | $(BUILD)/setup.stamp
	@tools/image/fetch_uboot $(BUILD)/uboot
	@[ -e $@ ] || { echo "image: no U-Boot for $(UBOOT); UBOOT= one of:" \
	  $$(cd $(BUILD)/uboot/usr/lib/u-boot && echo *-rk3399) >&2; exit 2; }

# A key of this folder alone, for development: docs/device.md says how to keep one.
$(KEYS)/cert.pem:
	@mkdir -p $(KEYS)
	@openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -noenc -days 36500 \
	  -subj "/CN=PIRVS development" -keyout $(KEYS)/key.pem -out $@ 2>/dev/null

ifeq ($(filter help clean setup format,$(MAKECMDGOALS)),)
-include $(patsubst %.o,%.d,$(filter $(OUT)/%,$(CARD_OBJ) $(RECEIVE_OBJ) $(FIRST_POSE_OBJ)))
endif
