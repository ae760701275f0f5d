# What people get beside the program: the site of the docs, Debian packages. Included by
# board/host/board.mk; no object depends on this file.
.PHONY: docs deb deb-test reproducible sweep people-test

docs: | $(BUILD)/setup.stamp ## the docs as a site, build/docs/index.html; finds dead links
	@tools/site/build $(BUILD)/docs

# The same revision gives the same bytes. VERSION= instead of the tag's.
DEB := $(BUILD)/deb
DEB_BUILD = tools/deb/build --out $(DEB) $(if $(VERSION),--version $(VERSION))
deb: $(OUT)/pirvs ## Debian packages with their bills of materials: build/deb; VERSION=
	@$(MAKE) -s BOARD=pc all
	@$(MAKE) -s BOARD=library all
	@$(MAKE) -s BOARD=ironsides all
	@$(DEB_BUILD) pirvs --arch amd64 --programs $(OUT)
	@$(DEB_BUILD) libpirvs0 --arch amd64 --programs $(BUILD)/library
	@$(DEB_BUILD) libpirvs-dev --arch amd64 --programs $(BUILD)/library
	@$(DEB_BUILD) pirvsd --arch amd64 --programs $(BUILD)/pc
	@$(DEB_BUILD) pirvsd --arch arm64 --programs $(BUILD)/ironsides --help-from $(BUILD)/pc

# Needs a network once, and some minutes.
FRESH_ROOT := $(BUILD)/debian/fresh-amd64.tar
deb-test: deb ## install the packages into a fresh Debian root, run the service, purge them
	@tools/deb/try_install $(FRESH_ROOT) $(DEB)/pirvsd_*_amd64.deb $(DEB)/libpirvs*_amd64.deb
	@tools/deb/try_install $(FRESH_ROOT) $(DEB)/pirvs_*_amd64.deb

# Of `make nightly`: an hour, as nothing comes from a cache. WHAT=bare one of them.
reproducible: ## two clean builds of this commit give the same bytes; WHAT="packages ironsides bare"
	@tools/check/reproducible $(BUILD)/reproducible $(WHAT)

sweep: $(OUT)/pirvs ## many runs, one table: ARGS='--recording PATH --seeds 1-5 --set name=a,b'
	@tools/sweep/sweep --pirvs $(OUT)/pirvs --out $(BUILD)/sweep $(ARGS)

# A cluster, a broker, a newcomer, packages: minutes, and daemons. Of `make nightly`.
people-test: $(OUT)/pirvs
	@for tool in sweep fleet site deb; do \
	  PIRVS_NIGHTLY=1 /usr/bin/python3 -B -m unittest discover -q -s tools/$$tool -p '*_test.py'; done
