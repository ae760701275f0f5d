// The card's partition table (GPT), whose last partition is to take what is free.
// In      How large the disk is, and its first sectors: the protective MBR, header and entries; or,
//         when those are damaged, the last ones.
// Out     grow: the same table for this disk: the last partition ends at kAlignment below the copy
//         of the table, which lies at the disk's end.
// Errors  kBadData: no such table, damaged, or of another shape. kEmpty: all is as it must be.
//         kFull: the disk is smaller than its table says.
// Cost    microseconds.
// Source  UEFI specification 2.10, section 5.3.
#pragma once

#include "board/card/slot_state.h"
#include "core/base/status.h"

namespace pirvs::card {

inline constexpr size_t kEntries = 128, kEntryBytes = 128;
inline constexpr size_t kEntrySectors = kEntries * kEntryBytes / kSectorBytes;
inline constexpr uint64_t kAlignment = 2048;  // sectors

struct PartitionTable {
  Sector header;
  uint8_t entries[kEntries * kEntryBytes];
};

struct Grown {
  int number = 0;  // of the partition that grew, from 1
  uint64_t first = 0, sectors = 0;
};

// Whether header and entries are whole, and the header was written for that sector.
bool is_whole(const PartitionTable& table, uint64_t header_sector);
// `table` becomes that of the disk, its header the first one's; header_of: the copy's.
Status grow(PartitionTable& table, uint64_t disk_sectors, Grown& out);
void make_copy(const PartitionTable& table, uint64_t disk_sectors, Sector& header);

}  // namespace pirvs::card
