#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <string>

namespace dcloc::node {

/// A message of any type as its bytes: what it is, the connection's header says.
struct RawMessage {
  std::string data;
};

}  // namespace dcloc::node

// What roscpp asks of a message type. "*" stands for all types.
namespace ros::message_traits {

template <>
struct IsMessage<dcloc::node::RawMessage> : TrueType {};
template <>
struct IsMessage<const dcloc::node::RawMessage> : TrueType {};

template <>
struct MD5Sum<dcloc::node::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const dcloc::node::RawMessage& /*message*/) { return value(); }
};

template <>
struct DataType<dcloc::node::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const dcloc::node::RawMessage& /*message*/) { return value(); }
};

template <>
struct Definition<dcloc::node::RawMessage> {
  static const char* value() { return ""; }
  static const char* value(const dcloc::node::RawMessage& /*message*/) { return value(); }
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<dcloc::node::RawMessage> {
  template <typename Stream>
  static void read(Stream& stream, dcloc::node::RawMessage& message) {
    const std::uint32_t size = stream.getLength();
    message.data.assign(reinterpret_cast<const char*>(stream.getData()), size);
    stream.advance(size);
  }
  template <typename Stream>
  static void write(Stream& stream, const dcloc::node::RawMessage& message) {
    std::memcpy(stream.advance(serializedLength(message)), message.data.data(),
                message.data.size());
  }
  static std::uint32_t serializedLength(const dcloc::node::RawMessage& message) {
    return static_cast<std::uint32_t>(message.data.size());
  }
};

}  // namespace ros::serialization
