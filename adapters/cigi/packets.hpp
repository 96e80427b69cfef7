#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// @file
/// Packets of the Common Image Generator Interface 3.3, after its Interface Control Document (Boeing
/// TST08I016, 2008), sections 4.1.1, 4.1.2 and 4.2.1. Written big-endian; the byte swap magic number of the
/// first packet marks this order. Both orders are read.

namespace touchstone::cigi {

/// Sizes of whole packets.
inline constexpr std::size_t kIgControlBytes = 24;
/// @copydoc kIgControlBytes
inline constexpr std::size_t kEntityControlBytes = 48;
/// @copydoc kIgControlBytes
inline constexpr std::size_t kStartOfFrameBytes = 24;
inline constexpr double kTicksPerSecond = 1e5;  ///< a timestamp counts 10 us

/// The image generator's mode, as the packets number it.
enum class IgMode : std::uint8_t { standby = 0, operate = 1, debug = 2, offline_maintenance = 3 };

/// The first packet of every message to the image generator, and the only one of its kind in it.
struct IgControl {
  std::int8_t database = 0;  ///< to load; 0: none
  IgMode mode = IgMode::operate;
  bool is_timestamp_valid = false;
  bool extrapolates = false;
  std::uint32_t host_frame = 0;     ///< one more with each message
  std::uint32_t timestamp = 0;      ///< [10 us], wraps around
  std::uint32_t last_ig_frame = 0;  ///< of the last Start of Frame that came

  friend bool operator==(const IgControl&, const IgControl&) = default;
};

/// An entity's state, as the packet numbers it.
enum class EntityState : std::uint8_t { standby = 0, active = 1, destroyed = 2 };

/// The place of an entity. An entity's axes: x forward, y to the right, z down. Angles turn it by yaw about
/// z, then by pitch about the new y, then by roll about the new x: R = Rz(yaw) Ry(pitch) Rx(roll).
struct EntityControl {
  std::uint16_t id = 0;  ///< 0 is the ownship
  EntityState state = EntityState::active;
  /// Attached: position is an offset in the parent's axes [m], the angles are against them. Otherwise
  /// latitude and longitude [deg] and altitude [m] on WGS 84, the angles against north, east, down at that
  /// place.
  bool is_attached = false;
  std::uint8_t alpha = 255;  ///< 255: opaque
  std::uint16_t type = 0;    ///< names the model
  std::uint16_t parent = 0;
  float roll = 0.0F;   ///< [-180, 180] deg
  float pitch = 0.0F;  ///< [-90, 90] deg
  float yaw = 0.0F;    ///< [0, 360) deg
  std::array<double, 3> position{};

  friend bool operator==(const EntityControl&, const EntityControl&) = default;
};

/// The first packet of every message from the image generator.
struct StartOfFrame {
  std::uint8_t major_version = 3;
  std::uint8_t minor_version = 3;
  std::int8_t database = 0;
  std::uint8_t status = 0;  ///< 0: normal
  IgMode mode = IgMode::standby;
  bool is_timestamp_valid = false;
  bool has_own_earth_model = false;  ///< the host's instead of WGS 84
  std::uint32_t ig_frame = 0;
  std::uint32_t timestamp = 0;  ///< [10 us]
  std::uint32_t last_host_frame = 0;

  friend bool operator==(const StartOfFrame&, const StartOfFrame&) = default;
};

/// The whole packet, big-endian. All fields are written as they are, unchecked.
void encode(const IgControl& packet, std::span<std::byte, kIgControlBytes> out) noexcept;
/// @copydoc encode(const IgControl&, std::span<std::byte, kIgControlBytes>)
void encode(const EntityControl& packet, std::span<std::byte, kEntityControlBytes> out) noexcept;

/// Reads the Start of Frame that a message begins with, of version 3.2 or 3.3; the rest of the message is not
/// read.
std::optional<StartOfFrame> decode_start_of_frame(std::span<const std::byte> message) noexcept;

}  // namespace touchstone::cigi
