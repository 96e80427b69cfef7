// The packets sent, read by an independent implementation: the CIGI dissector of Wireshark.

#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "cigi_fixture.hpp"
#include "output_fixture.hpp"
#include "touchstone/adapters/cigi/cigi_output.hpp"

namespace touchstone {
namespace {

using namespace cigi;
using nlohmann::json;

#ifdef TOUCHSTONE_TSHARK

/// Datagrams as a capture file: raw IPv4, from the host to port 8004 of the image generator.
std::string capture_file(const std::vector<Bytes>& datagrams) {
  std::string out;
  const auto little = [&](std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
  };
  const auto big = [&](std::uint64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(value >> (8 * i));
  };
  little(0xa1b2c3d4, 4), little(2, 2), little(4, 2), little(0, 8), little(65535, 4), little(228, 4);
  for (const Bytes& datagram : datagrams) {
    const auto udp_bytes = static_cast<std::uint32_t>(8 + datagram.size()), ip_bytes = 20 + udp_bytes;
    little(0, 8), little(ip_bytes, 4), little(ip_bytes, 4);
    big(0x4500, 2), big(ip_bytes, 2), big(0, 4), big(64, 1), big(17, 1), big(0, 2);
    big(0x7f000001, 4), big(0x7f000001, 4);
    big(8005, 2), big(8004, 2), big(udp_bytes, 2), big(0, 2);
    out.append(reinterpret_cast<const char*>(datagram.data()), datagram.size());
  }
  return out;
}

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> part;
  while (const std::size_t count = fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), count);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

std::string dissect_to_text(const std::vector<Bytes>& datagrams) {
  const TemporaryFile file("cigi.pcap");
  file.write(capture_file(datagrams));
  return output_of(std::string("'") + TOUCHSTONE_TSHARK + "' -r '" + file.path() +
                   "' -d udp.port==8004,cigi --no-duplicate-keys -T json 2>/dev/null");
}

json dissect(const std::vector<Bytes>& datagrams) {
  const std::string text = dissect_to_text(datagrams);
  EXPECT_EQ(text.find("_ws.malformed"), std::string::npos);
  return json::parse(text);
}

json dissected_message(const json& packet) { return packet.at("_source").at("layers").at("cigi"); }

/// One or several of the same name: a list.
json list_of(const json& message, const std::string& name) {
  if (!message.contains(name)) return json::array();
  const json& found = message.at(name);
  return found.is_array() ? found : json::array({found});
}

/// Every field by its name: all that the dissector must print, and nothing else.
using Fields = std::map<std::string, double>;

Fields fields_of(const json& packet) {
  Fields fields;
  for (const auto& [name, value] : packet.items())
    fields[name] = value.is_string() ? std::strtod(value.get<std::string>().c_str(), nullptr) : NAN;
  return fields;
}

Fields expected(const IgControl& packet) {
  return {{"cigi.packet_id", 1},
          {"cigi.packet_size", 24},
          {"cigi.version", 3},
          {"cigi.ig_control.db_number", packet.database},
          {"cigi.ig_control.ig_mode", static_cast<int>(packet.mode)},
          {"cigi.ig_control.timestamp_valid", packet.is_timestamp_valid},
          {"cigi.ig_control.extrapolation_enable", packet.extrapolates},
          {"cigi.ig_control.minor_version", 3},
          {"cigi.byte_swap", 0x8000},
          {"cigi.ig_control.host_frame_number", packet.host_frame},
          {"cigi.ig_control.timestamp", packet.timestamp},
          {"cigi.ig_control.last_ig_frame_number", packet.last_ig_frame}};
}

Fields expected(const EntityControl& packet) {
  return {{"cigi.packet_id", 2},
          {"cigi.packet_size", 48},
          {"cigi.entity_control.entity_id", packet.id},
          {"cigi.entity_control.entity_state", static_cast<int>(packet.state)},
          {"cigi.entity_control.attach_state", packet.is_attached},
          {"cigi.entity_control.coll_det_request", 0},
          {"cigi.entity_control.inherit_alpha", 0},
          {"cigi.entity_control.ground_ocean_clamp", 0},
          {"cigi.entity_control.animation_dir", 0},
          {"cigi.entity_control.animation_loop_mode", 0},
          {"cigi.entity_control.animation_state", 0},
          {"cigi.entity_control.extrapolation_enable", 0},
          {"cigi.entity_control.alpha", packet.alpha},
          {"cigi.entity_control.entity_type", packet.type},
          {"cigi.entity_control.parent_id", packet.parent},
          {"cigi.entity_control.roll", packet.roll},
          {"cigi.entity_control.pitch", packet.pitch},
          {"cigi.entity_control.yaw", packet.yaw},
          {"cigi.entity_control.lat_xoff", packet.position[0]},
          {"cigi.entity_control.lon_yoff", packet.position[1]},
          {"cigi.entity_control.alt_zoff", packet.position[2]}};
}

/// Reals are printed with 6 digits (floats) or 15 (doubles).
void expect_fields(const json& packet, const Fields& expected) {
  const Fields found = fields_of(packet);
  for (const auto& [name, value] : found) EXPECT_TRUE(expected.contains(name)) << name << " = " << value;
  for (const auto& [name, value] : expected) {
    ASSERT_TRUE(found.contains(name)) << name;
    const bool is_float = name.ends_with("roll") || name.ends_with("pitch") || name.ends_with("yaw");
    EXPECT_NEAR(found.at(name), value, std::abs(value) * (is_float ? 5e-6 : 5e-15)) << name;
  }
}

void expect_message(const json& message, const Message& sent) {
  const json controls = list_of(message, "cigi.ig_control");
  ASSERT_EQ(controls.size(), 1u);
  expect_fields(controls[0], expected(sent.control));
  const json entities = list_of(message, "cigi.entity_control");
  ASSERT_EQ(entities.size(), sent.entities.size());
  for (std::size_t i = 0; i < entities.size(); ++i) expect_fields(entities[i], expected(sent.entities[i]));
}

/// Frames through an output, as they come off the network.
std::vector<Bytes> sent(const Anchor& anchor, std::uint32_t objects, std::size_t frames) {
  Listener listener;
  CigiOptions options;
  options.port = listener.port();
  options.anchor = anchor;
  options.database = 3;
  CigiOutput output(options);
  for (std::uint32_t i = 0; i < objects; ++i) output.add_object({{i, 0}, "object " + std::to_string(i)});
  std::vector<Bytes> datagrams;
  for (MadeFrame& frame : make_frames(frames, objects, 40)) {
    if (frame.frame % 3 == 2) frame.poses.pop_back();  // gone: destroyed
    output.write(frame.view());
    datagrams.push_back(*listener.receive());
  }
  return datagrams;
}

void expect_dissected(const std::vector<Bytes>& datagrams) {
  const json packets = dissect(datagrams);
  ASSERT_EQ(packets.size(), datagrams.size());
  for (std::size_t i = 0; i < datagrams.size(); ++i)
    expect_message(dissected_message(packets[i]), read_message(datagrams[i]));
}

TEST(CigiTshark, AttachedEntitiesFieldByField) { expect_dissected(sent(AttachedTo{4711, z_up()}, 30, 20)); }

TEST(CigiTshark, EntitiesOnEarthFieldByField) {
  expect_dissected(sent(OnEarth{{29.56, -95.09, 5.0}, z_up()}, 5, 20));
}

TEST(CigiTshark, NoEntityOneAndMany) {
  std::vector<Bytes> datagrams = sent(AttachedTo{}, 1, 4);
  for (const std::uint32_t objects : {0u, 300u})
    for (Bytes& datagram : sent(AttachedTo{}, objects, 1)) datagrams.push_back(std::move(datagram));
  expect_dissected(datagrams);
}

// The test can fail: a packet of another size is seen as malformed.
TEST(CigiTshark, SeesWhatIsMalformed) {
  std::vector<Bytes> datagrams = sent(AttachedTo{}, 2, 1);
  datagrams[0].resize(datagrams[0].size() - 5);
  EXPECT_NE(dissect_to_text(datagrams).find("_ws.malformed"), std::string::npos);
}

// Both readers of a Start of Frame agree, in either byte order.
TEST(CigiTshark, StartOfFrameIsReadAsByTheDissector) {
  // The same packet in both byte orders.
  Bytes big(24, std::byte{0}), little(24, std::byte{0});
  const std::array<int, 8> head{101, 24, 3, 0x83, 9, 0x30 | 0x04 | 0x02, 0x80, 0x00};
  for (std::size_t i = 0; i < 8; ++i) big[i] = little[i] = static_cast<std::byte>(head[i]);
  std::swap(little[6], little[7]);
  for (std::size_t i = 0; i < 12; ++i) {
    big[8 + i] = static_cast<std::byte>(i * 17 + 1);
    little[8 + (i / 4 * 4) + (3 - i % 4)] = big[8 + i];
  }
  const json packets = dissect({big, little});
  ASSERT_EQ(packets.size(), 2u);
  // Each field as the dissector reads it.
  for (const Bytes& bytes : {big, little}) {
    const auto read = decode_start_of_frame(bytes);
    ASSERT_TRUE(read.has_value());
    const json message = dissected_message(packets[bytes == big ? 0 : 1]);
    expect_fields(message.at("cigi.sof"), {{"cigi.packet_id", 101},
                                           {"cigi.packet_size", 24},
                                           {"cigi.version", read->major_version},
                                           {"cigi.sof.db_number", read->database},
                                           {"cigi.sof.ig_status", read->status},
                                           {"cigi.sof.ig_mode", static_cast<int>(read->mode)},
                                           {"cigi.sof.timestamp_valid", read->is_timestamp_valid},
                                           {"cigi.sof.earth_reference_model", read->has_own_earth_model},
                                           {"cigi.sof.minor_version", read->minor_version},
                                           {"cigi.byte_swap", bytes[6] == std::byte{0x80} ? 0x8000 : 0x0080},
                                           {"cigi.sof.ig_frame_number", read->ig_frame},
                                           {"cigi.sof.timestamp", read->timestamp},
                                           {"cigi.sof.last_host_frame_number", read->last_host_frame}});
  }
}

#else

TEST(CigiTshark, NotFound) {
  GTEST_SKIP()
      << "tshark was not found when this was configured: no packet was checked against its dissector";
}

#endif

}  // namespace
}  // namespace touchstone
