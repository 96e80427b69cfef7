#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/cigi/coordinates.hpp"
#include "touchstone/adapters/cigi/packets.hpp"
#include "touchstone/contact_core/output/frame_output.hpp"

namespace touchstone {

/// An object's name and number at the image generator.
struct CigiEntity {
  std::string object;      ///< its name
  std::uint16_t id = 1;    ///< unique; 0 is the ownship
  std::uint16_t type = 0;  ///< names the model
  Pose X_OE;               ///< the model's axes (x forward, y right, z down) in the object's frame
};

/// The receiver, and how the scene is placed for it. The defaults are those of a scene attached to entity 0.
struct CigiOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8004;
  std::uint16_t local_port = 0;  ///< where the image generator answers; 0: any
  cigi::Anchor anchor = cigi::AttachedTo{};
  /// Objects that are not named here get the next free identifier from 1 on, and the same number as type.
  std::vector<CigiEntity> entities;
  cigi::IgMode mode = cigi::IgMode::operate;
  std::int8_t database = 0;  ///< asked for until the image generator reports it; 0: none
  /// Up to here unchanged entities are sent along, in turn. 1472 bytes are what Ethernet's 1500 leave.
  std::size_t datagram_bytes = 1472;
};

/// Shows frames on an image generator: one message, one datagram a frame, sent without waiting.
///
/// A message is an IG Control packet (the standard wants exactly one a frame) and Entity Control packets: of
/// every entity that has moved since it was last sent, then of the others in turn, as far as the datagram
/// goes, so that what a lost datagram held comes again. If more have moved than fit, the datagram is longer,
/// and IP splits it; no frame is ever shown in part. An object that is no longer in a frame is destroyed, in
/// kFarewells messages.
///
/// A message that the system does not take is dropped and counted; what it held counts as not sent. That
/// nobody listens is known only from an answer to an earlier datagram: an error is counted, and the message
/// is sent anyway.
class CigiOutput final : public FrameOutput {
 public:
  /// Most entities: a datagram of 65 507 bytes.
  static constexpr std::size_t kMostEntities = (65507 - cigi::kIgControlBytes) / cigi::kEntityControlBytes;
  static constexpr int kFarewells = 10;

  /// @throws InputError: a host that is not found, an invalid anchor or pose, an identifier given twice.
  explicit CigiOutput(CigiOptions options);
  ~CigiOutput() override;

  /// @throws InputError: no identifier left, or more than kMostEntities objects.
  void add_object(const OutputObject& object) override;
  void write(const OutputFrame& frame) noexcept override;
  OutputStatus status() const noexcept override;

  /// Returns the image generator's last report. Not to be called while a frame is written.
  std::optional<cigi::StartOfFrame> last_start_of_frame() const;
  std::uint16_t local_port() const noexcept;
  /// Datagrams longer than CigiOptions::datagram_bytes.
  std::uint64_t long_datagrams() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchstone
