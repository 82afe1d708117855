#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/core/map/synthetic_map.h"

namespace dcloc::server {

/// The bytes of a small valid map; another name gives other bytes.
inline std::vector<std::byte> SmallMap(const std::string& name = "spiral",
                                       std::size_t keyframe_count = 12) {
  SyntheticMap map(keyframe_count, 20);
  map.name = name;
  map.info.name_size_bytes = static_cast<std::uint32_t>(map.name.size());
  return map.Bytes();
}

}  // namespace dcloc::server
