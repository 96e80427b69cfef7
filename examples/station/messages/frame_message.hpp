#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/output/recording.hpp"
#include "touchstone/examples/station/exchange/merge_judge.hpp"
#include "touchstone/examples/station/flight/inputs.hpp"
#include "touchstone/examples/station/flight/session.hpp"

namespace touchstone::station {

inline constexpr std::uint32_t kFrameMagic = 0x31465354;  // "TSF1"
inline constexpr std::size_t kFrameHeader = 128;          ///< bytes
inline constexpr std::size_t kMostContacts = 256;         ///< in a frame's message

/// The fields of a frame's header beside the flight's; see protocol.md.
struct FrameFacts {
  InputStamp input;
  bool has_input = false;
  double started_us = 0.0, decided_us = 0.0;
  std::uint64_t missed = 0;
  bool is_replay = false;
};

/// The largest message of any of the scenes [bytes].
std::size_t most_frame_bytes(const StationScenes& scenes);

/// Writes a frame as protocol.md has it, little-endian, into `out`, which takes its size: no allocation where
/// its capacity is most_frame_bytes(). Sent and overwritten are 0: see set_client_part().
void write_frame(const Session& session, const JudgeFigures& judged, const FrameFacts& facts,
                 std::vector<std::uint8_t>& out);

/// Writes a frame of a record: one method, no joints, no distances, nothing commanded.
/// @param poses of all objects. @param first_solids of each object, among all of the scene's solids.
void write_recorded_frame(const RecordedFrame& frame, std::span<const Pose> poses,
                          std::span<const SolidIndex> first_solids, std::vector<std::uint8_t>& out);

/// Fills in what differs from client to client. @pre a message of write_frame().
void set_client_part(std::span<std::uint8_t> message, double sent_us, std::uint64_t overwritten);

}  // namespace touchstone::station
