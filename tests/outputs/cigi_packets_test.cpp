#include <gmock/gmock.h>

#include <array>

#include "cigi_fixture.hpp"
#include "touchstone/adapters/cigi/packets.hpp"

namespace touchstone {
namespace {

using namespace cigi;

template <std::size_t Size, class Packet>
std::array<int, Size> encoded(const Packet& packet) {
  std::array<std::byte, Size> bytes;
  encode(packet, bytes);
  std::array<int, Size> out;
  for (std::size_t i = 0; i < Size; ++i) out[i] = std::to_integer<int>(bytes[i]);
  return out;
}

// The bytes written by hand from the tables of the standard.
TEST(CigiPackets, IgControlByteByByte) {
  IgControl packet;
  packet.database = -5;
  packet.mode = IgMode::debug;
  packet.is_timestamp_valid = true;
  packet.extrapolates = true;
  packet.host_frame = 0x01020304;
  packet.timestamp = 0x05060708;
  packet.last_ig_frame = 0x090a0b0c;
  EXPECT_THAT(encoded<kIgControlBytes>(packet),
              ::testing::ElementsAre(1, 24, 3, 0xfb,                // identifier, size, version, database
                                     0x30 | 0x08 | 0x04 | 0x02, 0,  // minor version, flags, mode; reserved
                                     0x80, 0x00,                    // byte swap
                                     1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12,  //
                                     0, 0, 0, 0));
}

TEST(CigiPackets, EntityControlByteByByte) {
  EntityControl packet;
  packet.id = 0x0102;
  packet.state = EntityState::destroyed;
  packet.is_attached = true;
  packet.alpha = 200;
  packet.type = 0x0304;
  packet.parent = 0x0506;
  packet.roll = 1.0F;    // 3f800000
  packet.pitch = -2.0F;  // c0000000
  packet.yaw = 0.5F;     // 3f000000
  packet.position = {1.0, -2.0, 0.5};
  EXPECT_THAT(encoded<kEntityControlBytes>(packet),
              ::testing::ElementsAre(2, 48, 1, 2, 0x04 | 0x02, 0, 200, 0, 3, 4, 5, 6,          //
                                     0x3f, 0x80, 0, 0, 0xc0, 0, 0, 0, 0x3f, 0, 0, 0,           //
                                     0x3f, 0xf0, 0, 0, 0, 0, 0, 0, 0xc0, 0, 0, 0, 0, 0, 0, 0,  //
                                     0x3f, 0xe0, 0, 0, 0, 0, 0, 0));
}

Bytes start_of_frame_bytes(bool is_big_endian) {
  Bytes bytes;
  const auto add = [&](std::initializer_list<int> values) {
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  };
  add({101, 24, 3, 0xfe, 7, 0x30 | 0x08 | 0x04 | 0x01});
  if (is_big_endian) {
    add({0x80, 0x00, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  } else {
    add({0x00, 0x80, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9});
  }
  add({0, 0, 0, 0});
  return bytes;
}

TEST(CigiPackets, StartOfFrameInEitherByteOrder) {
  const StartOfFrame expected{3, 3, -2, 7, IgMode::operate, true, true, 0x01020304, 0x05060708, 0x090a0b0c};
  for (const bool is_big_endian : {true, false}) {
    const auto packet = decode_start_of_frame(start_of_frame_bytes(is_big_endian));
    ASSERT_TRUE(packet.has_value());
    EXPECT_EQ(*packet, expected);
  }
}

TEST(CigiPackets, WhatIsNoStartOfFrameIsRefused) {
  const Bytes good = start_of_frame_bytes(true);
  EXPECT_FALSE(decode_start_of_frame({}));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decode_start_of_frame(std::span(good).first(size)));
  // Identifier, size, major and minor version, byte swap.
  for (const std::size_t at : {0, 1, 2, 5, 6, 7}) {
    Bytes bad = good;
    bad[at] = std::byte{0x01};
    EXPECT_FALSE(decode_start_of_frame(bad)) << at;
  }
}

}  // namespace
}  // namespace touchstone
