#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"

/// @file
/// A crowd of tumbling solids, an arm and walls under mixed rules, and what is known about it: where events
/// are compared with the distances of all pairs.

namespace touchstone {

/// A pair of solids: slot and index in the tree of the one, then of the other; the lower slot first.
using SolidKey = std::array<std::uint32_t, 4>;

inline SolidKey key_of(const ContactEvent& event) {
  return {event.a.slot, event.solids.a, event.b.slot, event.solids.b};
}

class EventCrowd {
 public:
  struct Item {
    ObjectHandle object;
    std::shared_ptr<const HexahedronTree> tree;
    bool is_static = false, is_link = false, is_on = true;
    std::uint32_t carrier = kNoIndex;  // slot
  };
  explicit EventCrowd(std::uint64_t seed, std::string_view narrowphase = "native") : random_(seed) {
    BackendRegistry registry;
    register_core(registry);
    world_ = std::make_unique<ContactWorld>(registry.make_narrowphase(narrowphase),
                                            registry.make_broadphase("native"), kGap);
    PairRule standard;
    standard.policy = static_cast<ContactPolicy>(random_.below(4));
    standard.warn_distance = random_.one_in(2) ? 0.0 : 0.05;
    world_->set_default_rule(standard);
    default_policy_ = *standard.policy;
    add_items();
    draw_rules();
  }

  ContactWorld& world() const { return *world_; }
  const std::map<std::uint32_t, Item>& items() const { return items_; }
  const std::vector<MotionCommand>& commands() const { return commands_; }

  /// Sometimes switches, latches, exempts or removes something; then everything is commanded to go somewhere.
  FrameReport frame() {
    if (random_.one_in(4)) meddle();
    commands_.clear();
    const double pace = random_.one_in(5) ? 0.001 : random_.one_in(5) ? 1.0 : 0.1;
    for (const auto& [slot, item] : items_) {
      if (item.is_static || item.is_link || item.carrier != kNoIndex || random_.one_in(4)) continue;
      const Vector3 home = -world_->actual_pose(item.object).p;
      const Vector3 turn = random_.one_in(3) ? Vector3::Zero() : random_.vector(2.0 * pace);
      const Vector3 by =
          random_.one_in(3) ? random_.vector(pace) : Vector3(0.6 * pace * home + random_.vector(pace));
      commands_.push_back(world_->move_by(item.object, by, turn));
    }
    const std::span<const double> joints = world_->joint_values(arm_);
    goal_.assign(joints.begin(), joints.end());
    for (double& q : goal_) q += random_.uniform(-1.0, 1.0) * pace;
    const JointCommand arm_command{arm_, goal_};
    return world_->frame(commands_, {&arm_command, random_.one_in(4) ? 0u : 1u});
  }

  ContactPolicy policy_of(std::uint32_t a, std::uint32_t b) const {
    const auto rule = policies_.find(std::minmax(a, b));
    return rule == policies_.end() ? default_policy_ : rule->second;
  }

  bool is_checked(const SolidKey& key) const {
    const auto a = items_.find(key[0]), b = items_.find(key[2]);
    if (a == items_.end() || b == items_.end() || key[0] == key[2]) return false;
    if (!a->second.is_on || !b->second.is_on || (a->second.is_static && b->second.is_static)) return false;
    if (exempt_.count(key) != 0) return false;
    if (a->second.is_link && b->second.is_link) return !are_neighbours(key[0], key[2]);
    return body_of(key[0]) != body_of(key[2]);
  }

  /// Every pair of solids that is checked, by slots, and which of `solids` they are.
  struct Known {
    std::vector<SolidKey> keys;
    std::vector<SolidPair> pairs;
    std::vector<Hexahedron> solids;
    std::vector<Pose> X_WS;
    std::map<std::pair<std::uint32_t, std::uint32_t>, SolidIndex> index;  // of slot and solid
  };
  Known checked_pairs() const {
    Known out;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> names;
    for (const auto& [slot, item] : items_)
      for (std::uint32_t i = 0; i < item.tree->solids().size(); ++i) {
        out.index[{slot, i}] = static_cast<SolidIndex>(names.size());
        names.emplace_back(slot, i);
        out.solids.push_back(item.tree->solids()[i].solid);
        out.X_WS.push_back(world_->solid_poses(item.object)[i]);
      }
    for (SolidIndex a = 0; a < names.size(); ++a)
      for (SolidIndex b = a + 1; b < names.size(); ++b) {
        const SolidKey key{names[a].first, names[a].second, names[b].first, names[b].second};
        if (!is_checked(key)) continue;
        out.keys.push_back(key);
        out.pairs.push_back({a, b});
      }
    return out;
  }

 private:
  void add_items() {
    // Objects are kept by slot.
    const auto add = [&](const std::string& name, std::vector<PlacedHexahedron> solids, const Pose& X_WO,
                         bool is_static) {
      const auto tree = std::make_shared<HexahedronTree>(std::move(solids), name);
      const ObjectHandle object = world_->add({tree, X_WO, is_static});
      items_[object.slot] = {object, tree, is_static};
    };
    // Floor and wall, free solids, and an arm.
    add("floor", {{"box", Hexahedron::from_size({8, 8, 1}), {}}}, at(0, 0, -1.3), true);
    add("wall", {{"box", Hexahedron::from_size({0.1, 4, 4}), {}}}, at(1.6, 0, 0), true);
    const std::uint32_t count = 5 + random_.below(5);
    for (std::uint32_t i = 0; i < count; ++i) {
      std::vector<PlacedHexahedron> solids;
      solids.push_back({"first", draw_solid(), {}});
      if (random_.one_in(3)) solids.push_back({"second", draw_solid(), at(0.3, 0.1, 0)});
      Pose X = at(0.8 * (i % 3) - 0.8, 0.8 * (i / 3 % 3) - 0.8, 0.6 * (i / 9));
      if (random_.one_in(2)) X.R = rotation_about(Vector3::UnitZ(), random_.uniform(-3, 3));
      add("solid " + std::to_string(i), std::move(solids), X, false);
    }
    const auto mechanism = std::make_shared<const Mechanism>(planar_arm("arm", 3));
    arm_ = world_->add_mechanism({mechanism, at(-2.5, -0.5, 0.1), {}, {}, {}});
    for (int k = 1; k <= 3; ++k) {
      const ObjectHandle link = world_->link(arm_, std::to_string(k));
      items_[link.slot] = {link, mechanism->links()[static_cast<std::size_t>(k)].tree, false, true};
      links_.push_back(link.slot);
    }
  }

  Hexahedron draw_solid() {
    if (random_.one_in(3)) return random_solid(random_, 1.0);
    const double thin = random_.one_in(4) ? 0.05 : 1.0;
    return Hexahedron::from_size(
        {random_.uniform(0.2, 0.7), random_.uniform(0.2, 0.7) * thin, random_.uniform(0.2, 0.7)});
  }

  void draw_rules() {
    for (const auto& [a, first] : items_)
      for (const auto& [b, second] : items_) {
        if (!(a < b) || !random_.one_in(2)) continue;
        const auto policy = static_cast<ContactPolicy>(random_.below(4));
        PairRule rule;
        rule.policy = policy;
        rule.translation_only = random_.one_in(3);
        world_->set_pair_rule(first.object, second.object, rule);
        policies_[std::minmax(a, b)] = policy;
      }
  }

  void meddle() {
    // An object is switched, latched or let go, exempted, or taken out.
    auto chosen = items_.begin();
    std::advance(chosen, random_.below(static_cast<std::uint32_t>(items_.size())));
    Item& item = chosen->second;
    const std::uint32_t kind = random_.below(12);
    if (kind < 6) {
      item.is_on = !item.is_on || kind < 3;
      switch_object(item.object, item.is_on);
    } else if (kind < 10 && !item.is_static && !item.is_link) {
      if (item.carrier == kNoIndex) {
        if (carries(chosen->first)) return;
        const std::uint32_t carrier = items_.rbegin()->first;  // the arm's hand
        if (kind < 8 || carrier == chosen->first) return;
        world_->latch(items_.at(carrier).object, item.object);
        item.carrier = carrier;
      } else {
        world_->unlatch(item.object);
        item.carrier = kNoIndex;
      }
    } else if (kind == 10) {
      exempt_pair(chosen->first);
    } else if (!item.is_static && !item.is_link && item.carrier == kNoIndex && !carries(chosen->first) &&
               items_.size() > 7) {
      world_->remove(item.object);
      items_.erase(chosen);
    }
  }

  void exempt_pair(std::uint32_t slot) {
    const auto other = items_.begin();
    if (other->first >= slot || !random_.one_in(3)) return;
    world_->exempt({other->second.object, items_.at(slot).object});
    for (std::uint32_t i = 0; i < other->second.tree->solids().size(); ++i)
      for (std::uint32_t j = 0; j < items_.at(slot).tree->solids().size(); ++j)
        exempt_.insert({other->first, i, slot, j});
  }

  void switch_object(ObjectHandle object, bool on) { world_->select(SelectionChange::of(object, on)); }

  bool carries(std::uint32_t slot) const {
    for (const auto& [other, item] : items_)
      if (item.carrier == slot) return true;
    return false;
  }
  std::uint32_t body_of(std::uint32_t slot) const {
    while (items_.at(slot).carrier != kNoIndex) slot = items_.at(slot).carrier;
    return slot;
  }
  /// Adjacent links are exempt.
  bool are_neighbours(std::uint32_t a, std::uint32_t b) const {
    const auto place = [&](std::uint32_t slot) {
      return std::find(links_.begin(), links_.end(), slot) - links_.begin();
    };
    return std::abs(place(a) - place(b)) <= 1;
  }

  Random random_;
  std::unique_ptr<ContactWorld> world_;
  ContactPolicy default_policy_{};
  std::map<std::pair<std::uint32_t, std::uint32_t>, ContactPolicy> policies_;
  std::map<std::uint32_t, Item> items_;  // by slot
  std::set<SolidKey> exempt_;
  std::vector<std::uint32_t> links_;
  MechanismHandle arm_;
  std::vector<double> goal_;
  std::vector<MotionCommand> commands_;
};

}  // namespace touchstone
