// A map as bytes, to be kept between runs.
// In      save: a Map at rest, and where bytes go. load: where they come from.
// Out     load: the same points and keyframes under new handles. Tracks of the front-end and links
//         of the IMU between keyframes are not kept: they end with the run.
// Frames  as the map's. Little-endian, doubles as they are: header, points, keyframes, nodes,
//         CRC-32.
// Errors  kBadData: not a map, another version, cut off, damaged, or more than this build holds;
//         load then leaves an empty map, verify changes none. Others: of the sink or the source.
// Cost    ~240 bytes a point, ~60 an observation; no heap; 4 KiB of stack, and MapIndex.
// Source  own.
#pragma once

#include "modules/map/map.h"

namespace pirvs {

struct MapSink {
  void* context;
  Status (*write)(void* context, const void* data, size_t size);
};

struct MapSource {
  void* context;
  Status (*read)(void* context, void* data, size_t size);  // all of it; kBadData: the file ends
};

// What save_map() works in: by the slot of a point, its place among those saved.
struct MapIndex {
  uint32_t saved_as[kLandmarksMax];
};

Status save_map(const Map& map, const MapSink& sink, MapIndex& index);
// Whole and undamaged? Reads to the end.
Status verify_map(const MapSource& source);
// From the start again, into an empty map.
Status load_map(const MapSource& source, Map& map);

}  // namespace pirvs
