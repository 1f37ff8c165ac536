// SPDX-License-Identifier: Apache-2.0
// Takes the place of read_picture.cpp in a build without MALHA_PICTURES.
#include "host/model/vertex_map.h"
#include "malha/error.h"

namespace malha {

ChannelPicture read_picture(const std::string& path) {
  refuse(path, "", "a picture, and this malha was built with MALHA_PICTURES=OFF",
         "vertex colours, or a list of values");
}

}  // namespace malha
