# What people get beside the program: the site of the docs, Debian packages. Included by
# board/host/board.mk; no object depends on this file.
.PHONY: docs deb deb-test sweep people-test

docs: | $(BUILD)/setup.stamp ## the docs as a site, build/docs/index.html; finds dead links
	@tools/site/build $(BUILD)/docs

# The same revision gives the same bytes. VERSION= instead of the tag's.
DEB := $(BUILD)/deb
DEB_BUILD = tools/deb/build --out $(DEB) $(if $(VERSION),--version $(VERSION))
deb: $(OUT)/pirvs ## Debian packages with their bills of materials: build/deb; VERSION=
	@$(MAKE) -s BOARD=pc all
	@$(MAKE) -s BOARD=ironsides all
	@$(DEB_BUILD) pirvs --arch amd64 --programs $(OUT)
	@$(DEB_BUILD) pirvsd --arch amd64 --programs $(BUILD)/pc
	@$(DEB_BUILD) pirvsd --arch arm64 --programs $(BUILD)/ironsides --help-from $(BUILD)/pc

# Needs a network, and some minutes.
deb-test: deb ## install the packages into a fresh Debian root, and purge them
	@tools/deb/try_install $(DEB)/pirvsd_*_amd64.deb
	@tools/deb/try_install $(DEB)/pirvs_*_amd64.deb

sweep: $(OUT)/pirvs ## many runs, one table: ARGS='--recording PATH --seeds 1-5 --set name=a,b'
	@tools/sweep/sweep --pirvs $(OUT)/pirvs --out $(BUILD)/sweep $(ARGS)

# A cluster, a broker, a newcomer, packages: minutes, and daemons. Of `make nightly`.
people-test: $(OUT)/pirvs
	@for tool in sweep fleet site deb; do \
	  PIRVS_NIGHTLY=1 /usr/bin/python3 -B -m unittest discover -q -s tools/$$tool -p '*_test.py'; done
