// What    A recording's images one after the other, as files would hold them.
// In      An open Recording, which must outlive this.
//         web_only: who reads it takes JPEG and PNG alone.
// Out     The very bytes of its files or messages; PNG of what the player plays where there are
//         none: pixels of a pack, a video, raw images of a log, images that are turned.
// Errors  Images that cannot be read are left out, and counted as the player counts them.
// Cost    reading; PNG ~10 ms an image of 752 x 480.
#pragma once

#include <memory>
#include <vector>

#include "tools/dataset/image_store.h"
#include "tools/dataset/player.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

class ImageFiles {
 public:
  explicit ImageFiles(const Recording& recording, bool web_only = false);

  // Of the next frame of the recording, both cameras; without a format: none.
  void next(EncodedImage (&out)[2]);
  std::vector<Count> rejected() const;

 private:
  const Recording& recording_;
  std::unique_ptr<Player> player_;  // null: the bytes are there
  size_t frame_ = 0, missing_ = 0;

  EncodedImage load(const std::string& name) const;
};

}  // namespace pirvs::tools
