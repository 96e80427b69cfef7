#include "touchstone/examples/station/messages/frame_message.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"

namespace touchstone::station {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are written as the machine has them");

constexpr std::size_t kMethodBytes = 64, kPoseBytes = 32, kJointBytes = 16, kContactBytes = 64,
                      kDistanceBytes = 48;
constexpr std::size_t kSentAt = 56, kOverwrittenAt = 96;

enum HeaderFlag : std::uint32_t {
  kBrakes = 1,
  kVernier = 2,
  kJointMode = 4,
  kDynamics = 8,
  kRateLimited = 16,
  kAtLimit = 32,
  kNearSingularity = 64,
  kReplay = 128,
  kBlocked = 256,
  kInContact = 512
};
enum MethodFlag : std::uint16_t {
  kMethodBlocked = 1,
  kMethodReports = 2,
  kMethodSlid = 4,
  kMethodJudgedLate = 8
};
enum PoseFlag : std::uint32_t { kTouches = 1, kStopped = 2, kCarried = 4, kOff = 8 };
enum ContactKind : std::uint16_t { kIsInContact = 0, kIsNear = 1, kIsBlocked = 2 };

/// Appends figures to a message of known room.
class Writer {
 public:
  explicit Writer(std::vector<std::uint8_t>& out) : out_(out) { out_.clear(); }
  template <class T>
  void put(T value) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void put_floats(const Vector3& v) {
    for (int i = 0; i < 3; ++i) put(static_cast<float>(v[i]));
  }
  void zeros(std::size_t count) { out_.resize(out_.size() + count, 0); }

 private:
  std::vector<std::uint8_t>& out_;
};

/// Of one frame; spans into the world's report.
struct Contacts {
  std::array<const ContactEvent*, kMostContacts> events;
  std::size_t count = 0;
  std::span<const PushingContact> pushing;  // behind them
  std::size_t size() const { return count + pushing.size(); }
};

bool is_shown(EventKind kind) {
  return kind == EventKind::near || kind == EventKind::began || kind == EventKind::persists ||
         kind == EventKind::blocked || kind == EventKind::penetrating_at_start;
}

Contacts contacts_of(const Flight& flight) {
  Contacts out;
  if (flight.frame() == 0) return out;
  for (const ContactEvent& event : flight.events()) {
    if (!is_shown(event.kind) || !std::isfinite(event.geometry_at_end.separation)) continue;
    // A pair may begin in several of a frame's steps: it is one contact.
    const auto is_same = [&event](const ContactEvent* other) {
      return event.kind != EventKind::blocked && other->kind != EventKind::blocked && other->a == event.a &&
             other->b == event.b && other->solids == event.solids;
    };
    const auto shown = std::span(out.events).first(out.count);
    if (out.count < kMostContacts && std::none_of(shown.begin(), shown.end(), is_same))
      out.events[out.count++] = &event;
  }
  if (flight.guarded()) out.pushing = flight.guarded()->pushing();
  out.pushing = out.pushing.first(std::min(out.pushing.size(), kMostContacts - out.count));
  return out;
}

std::uint32_t header_flags(const Flight& flight, const FrameFacts& facts) {
  const FlightState& state = flight.state();
  const Method& mine = flight.methods().back();
  const auto flag = [](bool is_set, std::uint32_t bit) { return is_set ? bit : 0U; };
  return flag(state.brakes, kBrakes) | flag(state.vernier, kVernier) | flag(state.joint_mode, kJointMode) |
         flag(flight.was_limited(), kRateLimited) | flag(flight.is_at_limit(), kAtLimit) |
         flag(flight.was_damped(), kNearSingularity) | flag(state.dynamics, kDynamics) |
         flag(facts.is_replay, kReplay) | flag(mine.blocked, kBlocked) |
         flag(mine.reports_contact, kInContact);
}

/// A frame's header, without the fields that differ between clients.
struct Header {
  std::uint64_t frame = 0;
  double time = 0.0;
  InputStamp input = {};
  bool has_input = false;
  double started_us = 0.0, decided_us = 0.0;
  std::size_t objects = 0, methods = 0, joints = 0, contacts = 0, distances = 0;
  std::uint64_t missed = 0;
  std::uint32_t flags = 0, serial = 0, tip = 0;
};

std::size_t frame_bytes(const Header& header) {
  return kFrameHeader + header.methods * kMethodBytes + (header.methods + 1) * header.objects * kPoseBytes +
         header.joints * kJointBytes + header.contacts * kContactBytes + header.distances * kDistanceBytes;
}

void write_header(const Header& header, Writer& out) {
  // The page tells messages apart by kind and version.
  out.put(kFrameMagic);
  out.put(std::uint16_t{1});
  out.put(static_cast<std::uint16_t>(kFrameHeader));
  out.put(header.frame);
  // When the frame was commanded, received, begun and decided.
  out.put(header.time);
  out.put(header.has_input ? header.input.browser_us : kNaN);
  out.put(header.input.received_us);
  out.put(header.started_us);
  out.put(header.decided_us);
  out.put(0.0);
  // Whose command, and how much follows.
  out.put(header.input.client);
  out.put(header.input.number);
  out.put(static_cast<std::uint32_t>(header.objects));
  out.put(static_cast<std::uint16_t>(header.methods));
  out.put(static_cast<std::uint16_t>(header.joints));
  out.put(static_cast<std::uint32_t>(header.contacts));
  out.put(static_cast<std::uint32_t>(header.distances));
  // State, and padding to whole words.
  out.put(header.missed);
  out.put(std::uint64_t{0});
  out.put(header.flags);
  out.put(static_cast<std::uint32_t>(frame_bytes(header)));
  out.put(header.serial);
  out.put(header.tip);
  out.zeros(8);
}

Header header_of(const Session& session, const FrameFacts& facts, std::size_t contacts) {
  const Flight& flight = session.flight();
  Header out;
  out.frame = session.frame();
  out.time = session.time();
  out.input = facts.input;
  out.has_input = facts.has_input;
  out.started_us = facts.started_us;
  out.decided_us = facts.decided_us;
  out.objects = flight.scene().setting.object_count();
  out.methods = flight.methods().size();
  out.joints = flight.commanded_joints().size();
  out.contacts = contacts;
  out.distances = flight.distances().size();
  out.missed = facts.missed;
  out.flags = header_flags(flight, facts);
  out.serial = session.serial();
  out.tip = flight.state().tip;
  return out;
}

void write_method(const Method& method, const MergeFigures& judged, std::uint64_t frame, Writer& out) {
  const auto flag = [](bool is_set, std::uint16_t bit) { return is_set ? static_cast<unsigned>(bit) : 0U; };
  out.put(static_cast<std::uint16_t>(method.kind));
  out.put(static_cast<std::uint16_t>(
      flag(method.blocked, kMethodBlocked) | flag(method.reports_contact, kMethodReports) |
      flag(method.slid, kMethodSlid) | flag(judged.judged_frame < frame, kMethodJudgedLate)));
  out.put(judged.merged);
  out.put(judged.depth_now);
  out.put(judged.depth_worst);
  out.put(judged.judged_frame);
  out.put(judged.judged);
  out.put(method.blocked_frames);
  out.put(method.blocked ? static_cast<std::int32_t>(method.blocked_by.a) : -1);
  out.put(method.blocked ? static_cast<std::int32_t>(method.blocked_by.b) : -1);
  out.put(method.decide_us);
  out.put(judged.has_pair ? static_cast<std::int32_t>(judged.pair.a) : -1);
  out.put(judged.has_pair ? static_cast<std::int32_t>(judged.pair.b) : -1);
}

void write_pose(const Pose& X, std::uint32_t flags, Writer& out) {
  const Quaternion q = quaternion_of(X.R);
  out.put_floats(X.p);
  out.put_floats(q.v);
  out.put(static_cast<float>(q.w));
  out.put(flags);
}

std::uint32_t pose_flags(const Flight& flight, const Method& method, std::uint32_t object) {
  const SceneInstance& instance = flight.scene().setting.instance();
  const training::Formation& formation = method.flown->formation();
  std::uint32_t flags = 0;
  for (const training::LoggedEvent& event : method.log.events) {
    if (event.kind == EventKind::refused || event.kind == EventKind::at_limit) continue;
    if (instance.object_of(event.solids.a) != object && instance.object_of(event.solids.b) != object)
      continue;
    if (event.kind == EventKind::blocked) flags |= kStopped;
    if (event.kind == EventKind::began || event.kind == EventKind::persists) flags |= kTouches;
  }
  if (formation.carrier[object] != training::kNone) flags |= kCarried;
  if (!formation.is_on[object]) flags |= kOff;
  return flags;
}

void write_poses(const Flight& flight, Writer& out) {
  for (const Method& method : flight.methods()) {
    const std::span<const Pose> poses = method.flown->poses();
    for (std::uint32_t i = 0; i < poses.size(); ++i) write_pose(poses[i], pose_flags(flight, method, i), out);
  }
  for (const Pose& X : flight.commanded()) write_pose(X, 0, out);
}

void write_joints(const Flight& flight, Writer& out) {
  const std::span<const double> actual = flight.ours().joints(), commanded = flight.commanded_joints();
  const std::vector<double>& goals = flight.methods().back().goals;
  for (std::size_t i = 0; i < commanded.size(); ++i) {
    out.put(static_cast<float>(actual[i]));
    out.put(static_cast<float>(commanded[i]));
    out.put(static_cast<float>((goals[i] - actual[i]) * flight.rate()));
    out.put(flight.guarded() ? static_cast<float>(flight.guarded()->torques()[i]) : 0.0F);
  }
}

ContactKind kind_of(EventKind event) {
  return event == EventKind::near ? kIsNear : event == EventKind::blocked ? kIsBlocked : kIsInContact;
}

void write_contact(std::uint16_t method, EventKind kind, const SolidPair& solids, const PairGeometry& at_end,
                   Writer& out) {
  out.put(method);
  out.put(static_cast<std::uint16_t>(kind_of(kind)));
  out.put(solids.a);
  out.put(solids.b);
  out.put(static_cast<float>(at_end.separation));
  out.put_floats(at_end.p_A_W);
  out.put_floats(at_end.n_AB_W);
  out.zeros(24);
}

void write_pushing(const PushingContact& contact, Writer& out) {
  out.put(static_cast<std::uint16_t>(MethodKind::ours));
  out.put(static_cast<std::uint16_t>(kIsInContact));
  out.put(contact.solids.a);
  out.put(contact.solids.b);
  out.put(static_cast<float>(contact.separation));
  out.put_floats(contact.p_A_W);
  out.put_floats(contact.n_AB_W);
  out.put_floats(contact.force_W);
  out.zeros(12);
}

void write_distance(const NearDistance& distance, Writer& out) {
  out.put(distance.solids.a);
  out.put(distance.solids.b);
  out.put(distance.separation);
  out.put_floats(distance.p_A_W);
  out.put_floats(distance.p_B_W);
  out.zeros(8);
}

/// Of the only method of a record.
void write_recorded_method(const RecordedFrame& frame, Writer& out) {
  const auto has = [&](EventKind kind) {
    return std::any_of(frame.events.begin(), frame.events.end(),
                       [kind](const RecordedEvent& event) { return event.kind == kind; });
  };
  unsigned flags = 0;
  if (has(EventKind::blocked)) flags |= kMethodBlocked;
  if (has(EventKind::began) || has(EventKind::persists)) flags |= kMethodReports;
  out.put(std::uint16_t{0});
  out.put(static_cast<std::uint16_t>(flags));
  out.zeros(36);
  for (int i = 0; i < 2; ++i) out.put(std::int32_t{-1});  // who stopped it is not known
  out.zeros(8);
  for (int i = 0; i < 2; ++i) out.put(std::int32_t{-1});
}

}  // namespace

std::size_t most_frame_bytes(const StationScenes& scenes) {
  std::size_t most = 0;
  for (const auto& scene : scenes) {
    const std::size_t joints = scene->arm() != nullptr ? scene->arm()->joints.size() : 0;
    Header header;
    header.objects = scene->setting.object_count();
    header.methods = kMethods;
    header.joints = joints;
    header.contacts = kMostContacts;
    header.distances = NearDistances::kMost;
    most = std::max(most, frame_bytes(header));
  }
  return most;
}

void write_frame(const Session& session, const JudgeFigures& judged, const FrameFacts& facts,
                 std::vector<std::uint8_t>& out) {
  const Flight& flight = session.flight();
  const Contacts contacts = contacts_of(flight);
  Writer writer(out);
  write_header(header_of(session, facts, contacts.size()), writer);
  const bool counts = judged.epoch == session.epoch();
  for (const Method& method : flight.methods())
    write_method(method, counts ? judged.methods[static_cast<std::size_t>(method.kind)] : MergeFigures{},
                 session.frame(), writer);
  write_poses(flight, writer);
  write_joints(flight, writer);
  for (std::size_t i = 0; i < contacts.count; ++i) {
    const ContactEvent& event = *contacts.events[i];
    const SolidPair solids = {flight.solid_in_scene(event.a, event.solids.a),
                              flight.solid_in_scene(event.b, event.solids.b)};
    write_contact(static_cast<std::uint16_t>(MethodKind::ours), event.kind, solids, event.geometry_at_end,
                  writer);
  }
  for (const PushingContact& contact : contacts.pushing) write_pushing(contact, writer);
  for (const NearDistance& distance : flight.distances()) write_distance(distance, writer);
}

void write_recorded_frame(const RecordedFrame& frame, std::span<const Pose> poses,
                          std::span<const SolidIndex> first_solids, std::vector<std::uint8_t>& out) {
  std::vector<const RecordedEvent*> shown;
  for (const RecordedEvent& event : frame.events)
    if (is_shown(event.kind) && event.b != RecordedEvent::kNone &&
        std::isfinite(event.geometry_at_end.separation) && shown.size() < kMostContacts)
      shown.push_back(&event);
  Header header;
  header.frame = frame.frame;
  header.time = frame.time;
  header.objects = poses.size();
  header.methods = 1;
  header.contacts = shown.size();
  header.flags = kReplay;
  Writer writer(out);
  write_header(header, writer);
  write_recorded_method(frame, writer);
  for (int copy = 0; copy < 2; ++copy)  // commanded poses are in no record
    for (const Pose& X : poses) write_pose(X, 0, writer);
  for (const RecordedEvent* event : shown)
    write_contact(0, event->kind,
                  {first_solids[event->a] + event->solids.a, first_solids[event->b] + event->solids.b},
                  event->geometry_at_end, writer);
}

void set_client_part(std::span<std::uint8_t> message, double sent_us, std::uint64_t overwritten) {
  std::memcpy(message.data() + kSentAt, &sent_us, sizeof(sent_us));
  std::memcpy(message.data() + kOverwrittenAt, &overwritten, sizeof(overwritten));
}

}  // namespace touchstone::station
