// Where the files of bsp/api/storage.h go on Linux.
// In      An existing directory, a path below PATH_MAX; it is copied.
// Out     storage_open(name) opens directory/name. Default: the working directory.
// Errors  none here; storage_open says kNotFound if the directory does not exist.
// Source  bsp/api/storage.h.
#pragma once

namespace pirvs::bsp {

void set_storage_directory(const char* directory);

}  // namespace pirvs::bsp
