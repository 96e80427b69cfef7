#include "touchstone/tests/proof/soak/soak.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/random_solid.hpp"

namespace touchstone {
namespace {

constexpr double kGap = 1e-9;
constexpr std::uint32_t kWalls = 6, kMostMovers = 12, kGroups = 3;
/// Objects stray this far from the middle at most, or close to it [m].
constexpr double kScale = 50.0;

std::string group_name(std::uint32_t group) { return "group " + std::to_string(group); }

/// Ordered.
using HandlePair = std::pair<ObjectHandle, ObjectHandle>;
HandlePair ordered(ObjectHandle a, ObjectHandle b) { return a < b ? HandlePair{a, b} : HandlePair{b, a}; }

/// The state of one object as known without asking the world.
struct Item {
  ObjectHandle handle;
  Hexahedron solid;
  bool is_static;
  Pose initial, commanded;
  std::uint32_t group;
  std::uint32_t carrier = kNoIndex;      ///< index of an item
  std::vector<HandlePair> allowed = {};  ///< by its latch
  Pose X_CO;                             ///< in its carrier, as latched
};

/// The objects that are switched off, after the records.
struct Off {
  bool everything = false;
  std::set<std::string> groups;
  std::set<ObjectHandle> objects;
  std::set<HandlePair> pairs;

  void apply(const SelectionChange& change) {
    const auto set = [&](auto& members, const auto& value) {
      if (change.on)
        members.erase(value);
      else
        members.insert(value);
    };
    switch (change.scope) {
      case SelectionChange::Scope::everything:
        everything = !change.on;
        break;
      case SelectionChange::Scope::group:
        set(groups, std::string(change.group.text()));
        break;
      case SelectionChange::Scope::object:
        set(objects, change.first);
        break;
      case SelectionChange::Scope::pair:
        set(pairs, ordered(change.first, change.second));
        break;
      case SelectionChange::Scope::mechanism:  // there is none
        break;
    }
  }
};

/// Generations of the slots as they come and go, for the thread that selects.
using Generations = std::array<std::atomic<std::uint32_t>, kWalls + kMostMovers>;

/// Some of them name what is gone, or never was.
SelectionChange draw_selection(Random& random, const Generations& generations) {
  // Mostly on again: a world where nothing is checked has nothing to show.
  const bool on = !random.one_in(4);
  const auto draw_handle = [&] {
    const std::uint32_t slot = random.below(kWalls + kMostMovers);
    return ObjectHandle{slot, generations[slot] - (random.one_in(8) ? 1u : 0u)};
  };
  const std::uint32_t scope = random.below(20);
  if (scope == 0) return SelectionChange::of_everything(on || !random.one_in(4));
  if (scope < 4) return SelectionChange::of_group(group_name(random.below(kGroups + 1)), on);
  const ObjectHandle a = draw_handle();
  return scope < 12 ? SelectionChange::of(a, on) : SelectionChange::of(a, draw_handle(), on);
}

class SoakRun {
 public:
  explicit SoakRun(const Soak& run) : run_(run), random_(run.seed) {
    BackendRegistry registry;
    register_core(registry);
    world_ = std::make_unique<ContactWorld>(registry.make_narrowphase("native"),
                                            registry.make_broadphase("native"), kGap);
    add_walls();
    for (int i = 0; i < 8; ++i) add_mover();
    set_rule();
  }

  SoakFigures fly() {
    std::jthread selector;
    if (run_.replay == nullptr)
      selector = std::jthread([this](const std::stop_token& stop) {
        Random random(run_.seed + 1);
        while (!stop.stop_requested()) {
          world_->select(draw_selection(random, generations_));
          std::this_thread::sleep_for(std::chrono::microseconds(300));
        }
      });
    std::size_t next = 0;
    while (figures_.frames < run_.frames && figures_.violation.empty()) {
      change_set_up();
      if (run_.replay != nullptr)
        for (; next < run_.replay->size() && (*run_.replay)[next].frame == figures_.frames; ++next)
          world_->select((*run_.replay)[next].change);
      fly_frame();
    }
    if (selector.joinable()) selector.request_stop(), selector.join();
    return std::move(figures_);
  }

 private:
  // ---- set-up

  Item& add(const Vector3& p, const Hexahedron& solid, bool is_static) {
    // The walls name all the groups.
    const std::uint32_t group =
        items_.size() < kWalls ? static_cast<std::uint32_t>(items_.size()) % kGroups : random_.below(kGroups);
    Pose X;
    X.p = p;
    const auto tree = std::make_shared<HexahedronTree>(
        std::vector<PlacedHexahedron>{{"solid", solid, Pose{}}}, "object " + std::to_string(names_++));
    const ObjectHandle handle = world_->add({tree, X, is_static, {group_name(group)}});
    items_.push_back({handle, solid, is_static, X, X, group, kNoIndex, {}, {}});
    generations_[handle.slot] = handle.generation;
    needs_build_ = true;
    return items_.back();
  }

  void add_walls() {
    for (std::uint32_t i = 0; i < kWalls; ++i) {
      const std::uint32_t axis = i / 2;
      const double side = i % 2 ? 3.5 : -3.5;
      Vector3 size(10, 10, 10), p(0, 0, 0);
      size[axis] = 1, p[axis] = side;
      add(p, Hexahedron::from_size(size), true);
    }
  }

  std::uint32_t movers() const { return static_cast<std::uint32_t>(items_.size()) - kWalls; }
  std::uint32_t draw_item() { return random_.below(static_cast<std::uint32_t>(items_.size())); }

  void add_mover() {
    if (movers() == kMostMovers) return;
    const Vector3 p = random_.vector(2.5);
    add(p, random_solid(random_, random_.one_in(3) ? 0.05 : 1.0), false);
    ++figures_.added;
  }

  bool carries(std::uint32_t item) const {
    for (const Item& other : items_)
      if (other.carrier == item) return true;
    return false;
  }

  std::uint32_t root_of(std::uint32_t item) const {
    while (items_[item].carrier != kNoIndex) item = items_[item].carrier;
    return item;
  }

  /// @returns whether the world took it; it must refuse exactly what `allowed` says.
  bool attempt(bool allowed, const char* what, const std::function<void()>& change) {
    const std::uint64_t before = hash_of_poses();
    bool taken = true;
    try {
      change();
    } catch (const InputError&) {
      taken = false;
      ++figures_.refused_set_up;
    }
    if (taken != allowed) violate(std::string(what) + (taken ? " was taken" : " was refused"));
    if (hash_of_poses() != before) violate(std::string(what) + " moved something");
    return taken && allowed;
  }

  void remove() {
    const std::uint32_t i = draw_item();
    if (items_[i].is_static) return;
    const ObjectHandle handle = items_[i].handle;
    const bool allowed = items_[i].carrier == kNoIndex && !carries(i);
    if (!allowed || movers() <= 4) {
      if (!allowed) attempt(false, "removal while latched", [&] { world_->remove(handle); });
      return;
    }
    items_.erase(items_.begin() + i);
    attempt(true, "removal", [&] { world_->remove(handle); });
    for (Item& item : items_)
      if (item.carrier != kNoIndex && item.carrier > i) --item.carrier;
    const auto names_it = [&](const HandlePair& pair) {
      return pair.first == handle || pair.second == handle;
    };
    std::erase_if(exempt_, names_it);  // what else names it can name nothing any more
    gone_ = handle;
    removed_.push_back(handle);
    needs_build_ = true;
    ++figures_.removed;
    if (world_->is_alive(handle)) violate("a removed object lives");
    attempt(false, "a second removal", [&] { world_->remove(handle); });
    attempt(false, "a latch to what is gone", [&] { world_->latch(handle, items_[kWalls].handle); });
  }

  void latch() {
    const std::uint32_t carrier = draw_item(), carried = draw_item();
    const bool allowed =
        items_[carried].carrier == kNoIndex && !items_[carried].is_static && root_of(carrier) != carried;
    const std::uint32_t a = draw_item(), b = draw_item();
    std::vector<Exemption> exempt;
    if (a != b && random_.one_in(2)) exempt.push_back({items_[a].handle, items_[b].handle});
    if (attempt(allowed, "a latch",
                [&] { world_->latch(items_[carrier].handle, items_[carried].handle, exempt); })) {
      items_[carried].carrier = carrier;
      for (const Exemption& pair : exempt) items_[carried].allowed.push_back(ordered(pair.a, pair.b));
      items_[carried].X_CO = compose(inverse(pose_of(carrier)), pose_of(carried));
      ++figures_.latched;
    }
  }

  void unlatch() {
    const std::uint32_t i = draw_item();
    if (attempt(items_[i].carrier != kNoIndex, "an unlatching", [&] { world_->unlatch(items_[i].handle); })) {
      items_[i].carrier = kNoIndex;
      items_[i].allowed.clear();
      ++figures_.unlatched;
    }
  }

  void exempt() {
    const std::uint32_t a = draw_item(), b = draw_item();
    const HandlePair pair = ordered(items_[a].handle, items_[b].handle);
    if (attempt(a != b, "an exemption", [&] { world_->exempt({pair.first, pair.second, "solid"}); }))
      exempt_.insert(pair), ++figures_.exempted;
  }

  void unexempt() {
    const std::uint32_t a = draw_item(), b = draw_item();
    HandlePair pair = ordered(items_[a].handle, items_[b].handle);
    if (!exempt_.empty() && !random_.one_in(4)) pair = *exempt_.begin();
    const Exemption named{pair.second, pair.first, "", "solid"};
    attempt(exempt_.contains(pair), "an end of an exemption", [&] { world_->unexempt(named); });
    exempt_.erase(pair);
  }

  PairRule draw_rule() {
    constexpr std::array kPolicies{ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance,
                                   ContactPolicy::slide, ContactPolicy::slide};
    PairRule rule;
    if (!random_.one_in(4)) rule.policy = kPolicies[random_.below(5)];
    if (!random_.one_in(4)) rule.warn_distance = random_.one_in(2) ? 0.05 : 0.0;
    if (!random_.one_in(4)) rule.translation_only = random_.one_in(4);
    return rule;
  }

  void set_rule() {
    ++figures_.rules;
    const PairRule rule = draw_rule();
    const std::uint32_t a = draw_item(), b = draw_item();
    if (random_.one_in(2) || a == b) {
      world_->set_default_rule(rule);
      default_rule_ = rule;
      return;
    }
    world_->set_pair_rule(items_[a].handle, items_[b].handle, rule);
    pair_rules_[ordered(items_[a].handle, items_[b].handle)] = rule;
  }

  void reset() {
    world_->reset();
    ++figures_.resets;
    off_ = {};
    for (Item& item : items_) {
      item.carrier = kNoIndex;
      item.allowed.clear();
      item.commanded = item.initial;
      const Pose& X = world_->actual_pose(item.handle);
      if (!(X.p == item.initial.p && X.R == item.initial.R)) violate("reset left something elsewhere");
    }
  }

  void change_set_up() {
    if (random_.one_in(120)) add_mover();
    if (random_.one_in(120)) remove();
    if (random_.one_in(40)) latch();
    if (random_.one_in(6)) unlatch();
    if (random_.one_in(60)) exempt();
    if (random_.one_in(30)) unexempt();
    if (random_.one_in(150)) set_rule();
    if (random_.one_in(2500)) reset();
  }

  // ---- frames

  const Pose& pose_of(std::uint32_t item) const { return world_->actual_pose(items_[item].handle); }

  MotionCommand draw_command(std::uint32_t i) {
    // Most commands are small and lead back to the middle; some are extreme or no numbers.
    const ObjectHandle handle = items_[i].handle;
    const Vector3 home = -0.1 * pose_of(i).p;
    switch (random_.below(16)) {
      case 0: {  // a whole turn and a long way
        Vector3 turn = random_.vector(1.0);
        turn *= 2 * std::numbers::pi / std::max(norm(turn), 1e-9);
        const Vector3 by = random_.vector(3.0);
        return world_->move_by(handle, by, turn);
      }
      case 1:
      case 2:
      case 3: {  // creep
        const double pace = std::exp2(-random_.uniform(15, 35));
        const Vector3 by = random_.vector(pace);
        return world_->move_by(handle, by, random_.vector(pace));
      }
      case 4: {
        Vector3 by = random_.vector(1.0);
        by[random_.below(3)] = random_.one_in(2) ? kNaN : kInfinity;
        return random_.one_in(2) ? world_->move_by(handle, by, Vector3::Zero())
                                 : world_->move_by(handle, Vector3::Zero(), by);
      }
      case 5: {  // to a pose
        Pose X;
        X.p = random_.vector(2.4);
        return world_->go_to(handle, X);
      }
      default: {
        const Vector3 by = home + random_.vector(0.15);
        return world_->move_by(handle, by, random_.vector(0.3));
      }
    }
  }

  void draw_commands() {
    commands_.clear(), commanded_.assign(items_.size(), 0);
    expected_refusals_ = 0;
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      if (items_[i].is_static ? !random_.one_in(400) : random_.one_in(3)) continue;
      MotionCommand command = draw_command(i);
      if (gone_ != ObjectHandle{} && random_.one_in(200)) command.object = gone_;
      const bool is_pose = is_valid_pose(command.path.from()) && is_valid_pose(command.path.to());
      const bool taken = is_pose && command.object == items_[i].handle && !items_[i].is_static &&
                         items_[i].carrier == kNoIndex;
      expected_refusals_ += !taken;
      if (taken) commanded_[i] = 1, items_[i].commanded = command.path.to();
      commands_.push_back(command);
    }
  }

  void fly_frame() {
    draw_commands();
    before_.clear();
    for (std::uint32_t i = 0; i < items_.size(); ++i) before_.push_back(pose_of(i));
    const FrameReport report = world_->frame(commands_);
    if (report.frame != figures_.frames) violate("frames are counted wrongly");
    take_selection(report);
    check_report(report);
    check_poses();
    check_pairs();
    ++figures_.frames;
    figures_.commands += commands_.size();
    figures_.blocked += report.blocked_movers;
    figures_.slid += report.slide_steps > 0;
    figures_.iteration_limits += report.iteration_limits;
    figures_.pose_hash = figures_.pose_hash * 0x100000001b3 ^ hash_of_poses();
  }

  /// A long run keeps what every frame reports: the world's own record has an end.
  void take_selection(const FrameReport& report) {
    for (const SelectionChange& change : report.selections) {
      if (!is_known(change)) violate("a selection of what is gone came into force");
      figures_.record.push_back({report.frame, change});
      off_.apply(change);
      ++figures_.selections;
    }
    for (const SelectionChange& change : report.refused_selections)
      if (is_known(change)) violate("a good selection was refused");
    figures_.refused_selections += report.refused_selections.size();
    const auto record = world_->selection_record();
    if (record.size() + world_->selections_left_out() != figures_.record.size())
      violate("a selection is neither recorded nor counted");
    for (; records_ < record.size(); ++records_) {
      const SelectionRecord& kept = figures_.record[records_];
      if (record[records_].frame != kept.frame || record[records_].change != kept.change)
        violate("a selection is recorded with another frame");
    }
  }

  bool is_known(const SelectionChange& change) const {
    using Scope = SelectionChange::Scope;
    const bool names_first = change.scope == Scope::object || change.scope == Scope::pair;
    if (names_first && item_of(change.first) == kNoIndex) return false;
    if (change.scope == Scope::pair)
      return item_of(change.second) != kNoIndex && change.first != change.second;
    return change.scope != Scope::group || change.group.text() != group_name(kGroups);
  }

  std::uint32_t item_of(ObjectHandle handle) const {
    for (std::uint32_t i = 0; i < items_.size(); ++i)
      if (items_[i].handle == handle) return i;
    return kNoIndex;
  }

  bool is_exempt(const HandlePair& pair) const {
    if (exempt_.contains(pair)) return true;
    for (const Item& item : items_)
      if (std::find(item.allowed.begin(), item.allowed.end(), pair) != item.allowed.end()) return true;
    return false;
  }

  bool is_checked(std::uint32_t i, std::uint32_t j) const {
    if (root_of(i) == root_of(j) || (items_[i].is_static && items_[j].is_static)) return false;
    const HandlePair pair = ordered(items_[i].handle, items_[j].handle);
    if (off_.everything || off_.groups.contains(group_name(items_[i].group)) ||
        off_.groups.contains(group_name(items_[j].group)))
      return false;
    return !off_.objects.contains(pair.first) && !off_.objects.contains(pair.second) &&
           !off_.pairs.contains(pair) && !is_exempt(pair);
  }

  ContactPolicy policy_of(std::uint32_t i, std::uint32_t j) const {
    const auto rule = pair_rules_.find(ordered(items_[i].handle, items_[j].handle));
    if (rule != pair_rules_.end() && rule->second.policy) return *rule->second.policy;
    return default_rule_.policy.value_or(ContactPolicy::hold);
  }

  /// Since the last frame: the next one still says that its contacts ended.
  bool was_removed(ObjectHandle object) const {
    return std::find(removed_.begin(), removed_.end(), object) != removed_.end();
  }

  void check_report(const FrameReport& report) {
    // Events: of checked objects that are there, in order, within the frame, with geometry.
    std::uint64_t refused = 0;
    std::pair<std::uint32_t, std::uint32_t> last{0, 0};
    for (const ContactEvent& event : report.events) {
      if (event.kind == EventKind::refused) {
        ++refused;
        continue;
      }
      ++figures_.contact_events;
      if (event.kind == EventKind::ended && (was_removed(event.a) || was_removed(event.b))) continue;
      const std::uint32_t i = item_of(event.a), j = item_of(event.b);
      if (i == kNoIndex || j == kNoIndex || i == j) return violate("an event names an object that is gone");
      const std::pair pair{event.a.slot, event.b.slot};
      if (!(event.a.slot < event.b.slot) || pair < last) return violate("events are out of order");
      last = pair;
      if (!(event.s >= 0.0 && event.s <= 1.0)) return violate("an event outside its frame");
      if (!std::isfinite(event.geometry.separation) || !(std::abs(norm(event.geometry.n_AB_W) - 1.0) < 1e-9))
        return violate("an event without geometry");
      if (event.kind != EventKind::ended && !is_checked(i, j))
        return violate("an event of a pair that is not checked");
    }
    // Figures of the frame.
    removed_.clear();
    figures_.refused += refused;
    if (refused != expected_refusals_)
      violate(std::to_string(refused) + " commands refused, not " + std::to_string(expected_refusals_));
    if (report.slide_steps > kMostSlideSteps) violate("too many sub-steps");
    std::uint32_t movers = 0;
    for (const std::uint8_t commanded : commanded_) movers += commanded;
    if (report.blocked_movers > movers) violate("more movers blocked than commanded");
    if (report.check != MotionCheck::proven) violate("native is not sampled");
  }

  void check_poses() {
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      const Item& item = items_[i];
      const Pose& X = pose_of(i);
      if (!is_valid_pose(X)) return violate("object " + std::to_string(i) + " is at no pose");
      figures_.worst_rotation = std::max(figures_.worst_rotation,
                                         (X.R.transpose() * X.R - Matrix3::Identity()).cwiseAbs().maxCoeff());
      const bool moved = !(X.p == before_[i].p && X.R == before_[i].R);
      if (moved && !commanded_[root_of(i)]) return violate("something moved that was not commanded");
      if (commanded_[i] && !(world_->commanded_pose(item.handle).p == item.commanded.p &&
                             world_->commanded_pose(item.handle).R == item.commanded.R))
        return violate("the commanded pose is not the one commanded");
      if (item.carrier != kNoIndex) {
        const Pose expected = compose(pose_of(item.carrier), item.X_CO);
        if (!(norm(expected.p - X.p) < 1e-12 * kScale && (expected.R - X.R).cwiseAbs().maxCoeff() < 1e-12))
          return violate("a carried object came off its carrier by " +
                         std::to_string(norm(expected.p - X.p)));
      }
      const std::size_t parts = world_->executed_parts();
      if (parts > 0 && norm(world_->executed_pose(item.handle, parts - 1, 1.0).p - X.p) > 1e-12 * kScale)
        return violate("the executed path ends elsewhere");
    }
  }

  void check_pairs() {
    if (needs_build_) {
      solids_.clear();
      for (const Item& item : items_) solids_.push_back(item.solid);
      native_->build(solids_);
      query_ = std::make_unique<NarrowphaseQuery>(*native_, solids_.size());
      needs_build_ = false;
    }
    const double room = kSeparationRounding * kScale * static_cast<double>(1 + world_->executed_parts());
    for (std::uint32_t i = 0; i < items_.size(); ++i)
      for (std::uint32_t j = i + 1; j < items_.size(); ++j) {
        if (!is_checked(i, j) || policy_of(i, j) == ContactPolicy::cue) continue;
        const Sphere &of_i = solids_[i].bounding_sphere(), &of_j = solids_[j].bounding_sphere();
        if (norm(transform(pose_of(i), of_i.centre) - transform(pose_of(j), of_j.centre)) >
            (of_i.radius + of_j.radius) * (1 + 1e-9))
          continue;
        check_pair(i, j, room);
      }
  }

  void check_pair(std::uint32_t i, std::uint32_t j, double room) {
    ++figures_.pairs_checked;
    PairGeometry now{}, start{};
    query_->set_pair({i, j});
    query_->separation(pose_of(i), pose_of(j), now);
    if (now.separation > 0.0) return;
    query_->separation(before_[i], before_[j], start);
    if (start.separation > 0.0)
      return violate("objects " + std::to_string(i) + " and " + std::to_string(j) + " overlap by " +
                     std::to_string(-now.separation) + " m, after " + std::to_string(start.separation) +
                     " m apart");
    ++figures_.overlapping_starts;
    figures_.worst_growth = std::max(figures_.worst_growth, start.separation - now.separation);
    if (now.separation < start.separation - room) violate("an overlap deepened");
  }

  std::uint64_t hash_of_poses() const {
    std::uint64_t hash = 0xcbf29ce484222325;
    const auto add_number = [&](double x) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
    };
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
      for (int k = 0; k < 3; ++k) add_number(pose_of(i).p[k]);
      for (int k = 0; k < 9; ++k) add_number(pose_of(i).R(k / 3, k % 3));
    }
    return hash;
  }

  void violate(const std::string& what) {
    if (figures_.violation.empty())
      figures_.violation = "frame " + std::to_string(figures_.frames) + ": " + what;
  }

  const Soak& run_;
  Random random_;
  std::unique_ptr<ContactWorld> world_;
  std::vector<Item> items_;  // the walls first
  Off off_;
  PairRule default_rule_;
  std::map<HandlePair, PairRule> pair_rules_;
  std::set<HandlePair> exempt_;
  Generations generations_ = {};
  ObjectHandle gone_;
  std::vector<ObjectHandle> removed_;
  std::uint64_t names_ = 0;
  std::size_t records_ = 0;

  std::vector<MotionCommand> commands_;
  std::vector<std::uint8_t> commanded_;  // by item: a good command
  std::vector<Pose> before_;
  std::uint64_t expected_refusals_ = 0;

  bool needs_build_ = true;
  std::vector<Hexahedron> solids_;
  std::unique_ptr<Narrowphase> native_ = make_native();
  std::unique_ptr<NarrowphaseQuery> query_;
  SoakFigures figures_;
};

}  // namespace

SoakFigures soak(const Soak& run) { return SoakRun(run).fly(); }

std::string describe(const SoakFigures& f) {
  std::ostringstream out;
  out << f.frames << " frames, " << f.commands << " commands, " << f.refused << " refused, " << f.blocked
      << " movers blocked, " << f.slid << " frames slid\n"
      << f.added << " added, " << f.removed << " removed, " << f.latched << " latched, " << f.unlatched
      << " unlatched, " << f.resets << " resets, " << f.rules << " rules, " << f.refused_set_up
      << " set-up calls refused, " << f.exempted << " exemptions, " << f.selections << " selections and "
      << f.refused_selections << " refused\n"
      << f.contact_events << " contact events, " << f.pairs_checked << " pairs checked, "
      << f.overlapping_starts << " of them overlapping from the start, deeper by " << f.worst_growth
      << " m at most; rotations off by " << f.worst_rotation << "; " << f.iteration_limits
      << " iteration limits\n"
      << "hash of all poses " << std::hex << f.pose_hash << std::dec << "\n"
      << (f.violation.empty() ? "every invariant true" : "VIOLATION: " + f.violation) << '\n';
  return out.str();
}

}  // namespace touchstone
