#include "touchstone/adapters/cigi/cigi_output.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>

#include "touchstone/adapters/cigi/udp_socket.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace cigi;

constexpr int kMostAnswers = 16;  // read in one frame

struct Entity {
  ObjectHandle handle;
  std::string object;
  Pose X_OE;
  EntityControl packet;
  bool is_known = false;    // shown, or still being destroyed: to be sent
  bool is_present = false;  // in this frame
  bool is_due = false;      // changed since it was sent
  bool is_in_message = false;
  int farewells = 0;
};

struct Stamp {
  std::uint32_t ticks;
  bool is_valid;
};

Stamp stamp_of(double time) {
  const double ticks = std::nearbyint(time * kTicksPerSecond);
  if (!(std::abs(ticks) < 0x1p62)) return {0, false};
  return {static_cast<std::uint32_t>(static_cast<std::uint64_t>(static_cast<std::int64_t>(ticks))), true};
}

void validate(const CigiOptions& options) {
  validate(options.anchor);
  for (auto entity = options.entities.begin(); entity != options.entities.end(); ++entity) {
    validate_pose(entity->X_OE, "cigi: entity of object '" + entity->object + "'");
    for (auto other = options.entities.begin(); other != entity; ++other) {
      if (other->id == entity->id || other->object == entity->object)
        throw InputError("cigi: entity " + std::to_string(entity->id) + " of object '" + entity->object +
                         "' is given twice");
    }
  }
}

}  // namespace

struct CigiOutput::State {
  explicit State(CigiOptions given)
      : options(std::move(given)), socket(options.host, options.port, options.local_port) {
    message.resize(kIgControlBytes + kMostEntities * kEntityControlBytes);
  }

  const CigiOptions options;
  UdpSocket socket;
  std::vector<Entity> entities;
  std::vector<std::byte> message;
  std::size_t message_bytes = 0;
  std::size_t next_in_turn = 0;
  std::uint32_t host_frame = 0;
  std::optional<StartOfFrame> answer;
  std::atomic<std::uint64_t> offered{0}, delivered{0}, dropped{0}, errors{0}, long_datagrams{0};
  std::atomic<int> last_error{0};

  void take_answers();
  void update(const OutputFrame& frame);
  void start_message(double time);
  void add(Entity& entity);
  void fill_message();
  bool send();
  void note_error(int error);
  void finish_message(bool is_sent);
  std::uint16_t free_id() const;
  std::vector<Entity>::iterator find(ObjectHandle handle);
};

CigiOutput::CigiOutput(CigiOptions options) {
  validate(options);
  state_ = std::make_unique<State>(std::move(options));
}

CigiOutput::~CigiOutput() = default;

std::uint16_t CigiOutput::State::free_id() const {
  for (std::uint32_t id = 1; id <= 0xffff; ++id) {
    const auto has_id = [&](const CigiEntity& entity) { return entity.id == id; };
    const auto uses_id = [&](const Entity& entity) { return entity.packet.id == id; };
    if (std::none_of(options.entities.begin(), options.entities.end(), has_id) &&
        std::none_of(entities.begin(), entities.end(), uses_id))
      return static_cast<std::uint16_t>(id);
  }
  throw InputError("cigi: no entity identifier is left");
}

std::vector<Entity>::iterator CigiOutput::State::find(ObjectHandle handle) {
  const auto place =
      std::lower_bound(entities.begin(), entities.end(), handle.slot,
                       [](const Entity& a, std::uint32_t slot) { return a.handle.slot < slot; });
  for (auto entity = place; entity != entities.end() && entity->handle.slot == handle.slot; ++entity)
    if (entity->handle == handle) return entity;
  return entities.end();
}

void CigiOutput::add_object(const OutputObject& object) {
  State& s = *state_;
  Entity entity;
  entity.handle = object.handle;
  entity.object = object.name;
  const auto is_named = [&](const CigiEntity& given) { return given.object == object.name; };
  const auto given = std::find_if(s.options.entities.begin(), s.options.entities.end(), is_named);
  if (given != s.options.entities.end()) {
    entity.packet.id = given->id;
    entity.packet.type = given->type;
    entity.X_OE = given->X_OE;
  }
  // Names are unique among what is alive: one that comes again takes the place of the one that is gone.
  const auto is_same = [&](const Entity& other) { return other.object == object.name; };
  const auto former = std::find_if(s.entities.begin(), s.entities.end(), is_same);
  if (given == s.options.entities.end()) {
    entity.packet.id = former != s.entities.end() ? former->packet.id : s.free_id();
    entity.packet.type = entity.packet.id;
  }
  if (former != s.entities.end()) {
    s.entities.erase(former);
  } else if (s.entities.size() == kMostEntities) {
    throw InputError("cigi: object '" + object.name + "' is one more than a message holds, " +
                     std::to_string(kMostEntities));
  }
  const auto place =
      std::upper_bound(s.entities.begin(), s.entities.end(), object.handle.slot,
                       [](std::uint32_t slot, const Entity& other) { return slot < other.handle.slot; });
  s.entities.insert(place, std::move(entity));
}

void CigiOutput::write(const OutputFrame& frame) noexcept {
  State& s = *state_;
  s.offered.fetch_add(1, std::memory_order_relaxed);
  s.take_answers();
  s.update(frame);
  s.start_message(frame.time);
  s.fill_message();
  s.finish_message(s.send());
}

void CigiOutput::State::take_answers() {
  std::array<std::byte, kStartOfFrameBytes> bytes;
  for (int i = 0; i < kMostAnswers; ++i) {
    const std::ptrdiff_t count = socket.receive(bytes);
    if (count == -EAGAIN) return;
    if (count < 0) {
      note_error(static_cast<int>(-count));
      continue;
    }
    if (const auto read = decode_start_of_frame(std::span(bytes).first(static_cast<std::size_t>(count))))
      answer = read;
  }
}

void CigiOutput::State::update(const OutputFrame& frame) {
  for (Entity& entity : entities) entity.is_present = false;
  for (const ShownPose& pose : frame.poses) {
    const auto entity = find(pose.object);
    if (entity == entities.end()) continue;
    EntityControl packet = entity->packet;
    packet.state = EntityState::active;
    place(options.anchor, compose(pose.X_WO, entity->X_OE), packet);
    if (!entity->is_known || !(packet == entity->packet)) entity->is_due = true;
    entity->packet = packet;
    entity->is_known = entity->is_present = true;
  }
  for (Entity& entity : entities) {
    if (entity.is_present || !entity.is_known) continue;
    if (entity.packet.state == EntityState::active) entity.farewells = kFarewells;
    entity.packet.state = EntityState::destroyed;
    entity.is_due = true;
  }
}

void CigiOutput::State::start_message(double time) {
  const Stamp stamp = stamp_of(time);
  IgControl control;
  const bool is_loaded =
      answer && (answer->database == options.database || answer->database == -options.database);
  control.database = is_loaded ? std::int8_t{0} : options.database;
  control.mode = options.mode;
  control.timestamp = stamp.ticks;
  control.is_timestamp_valid = stamp.is_valid;
  control.host_frame = host_frame;
  control.last_ig_frame = answer ? answer->ig_frame : 0;
  encode(control, std::span(message).first<kIgControlBytes>());
  message_bytes = kIgControlBytes;
}

void CigiOutput::State::add(Entity& entity) {
  encode(entity.packet, std::span(message).subspan(message_bytes).first<kEntityControlBytes>());
  message_bytes += kEntityControlBytes;
  entity.is_in_message = true;
}

void CigiOutput::State::fill_message() {
  for (Entity& entity : entities) {
    entity.is_in_message = false;
    if (entity.is_due) add(entity);
  }
  for (std::size_t i = 0; i < entities.size(); ++i) {
    if (message_bytes + kEntityControlBytes > options.datagram_bytes) return;
    if (next_in_turn >= entities.size()) next_in_turn = 0;
    Entity& entity = entities[next_in_turn++];
    if (entity.is_known && !entity.is_in_message) add(entity);
  }
}

void CigiOutput::State::note_error(int error) {
  errors.fetch_add(1, std::memory_order_relaxed);
  last_error.store(error, std::memory_order_relaxed);
}

bool CigiOutput::State::send() {
  const auto datagram = std::span<const std::byte>(message).first(message_bytes);
  int error = socket.send(datagram);
  for (int attempt = 0; error != 0 && attempt < 2; ++attempt) {
    note_error(error);
    if (error != ECONNREFUSED || attempt > 0) return false;
    error = socket.send(datagram);  // that was about an earlier one
  }
  return error == 0;
}

void CigiOutput::State::finish_message(bool is_sent) {
  (is_sent ? delivered : dropped).fetch_add(1, std::memory_order_relaxed);
  if (!is_sent) return;
  if (message_bytes > options.datagram_bytes) long_datagrams.fetch_add(1, std::memory_order_relaxed);
  ++host_frame;
  for (Entity& entity : entities) {
    if (!entity.is_in_message) continue;
    entity.is_due = false;
    if (entity.packet.state == EntityState::destroyed && --entity.farewells == 0) entity.is_known = false;
  }
}

OutputStatus CigiOutput::status() const noexcept {
  const State& s = *state_;
  return {s.offered.load(std::memory_order_relaxed), s.delivered.load(std::memory_order_relaxed),
          s.dropped.load(std::memory_order_relaxed), s.errors.load(std::memory_order_relaxed),
          s.last_error.load(std::memory_order_relaxed)};
}

std::optional<StartOfFrame> CigiOutput::last_start_of_frame() const { return state_->answer; }
std::uint16_t CigiOutput::local_port() const noexcept { return state_->socket.local_port(); }
std::uint64_t CigiOutput::long_datagrams() const noexcept {
  return state_->long_datagrams.load(std::memory_order_relaxed);
}

}  // namespace touchstone
