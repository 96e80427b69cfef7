#include "touchstone/contact_core/mechanism/configuration_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/obstacle_tree.hpp"

// A configuration is checked in three steps. Each link's box, along the link's axes (booms are long and
// thin, and turned), goes through a tree of the obstacles' boxes; where they may meet, the boxes of its
// hexahedra are looked at one by one, and the obstacle's sphere. Boxes of links are then compared with each
// other in the same manner. Pairs that are left go to the narrowphase in blocks, as soon as one is full, and
// the first pair that is not separated ends the check.
//
// Boxes are compared in doubles. A link's frame is a product of at most as many rigid frames as there are
// joints, each off orthonormal by kFrameTolerance = 2^-48 and a few roundings of 2^-53: a coordinate along
// its axes is wrong by less than 2^-46 of the scene's size a joint. So much slack is given to every
// comparison.

namespace touchstone {
namespace {

/// Pairs that are asked at once: two vectors of the widest kernels.
constexpr std::size_t kBlock = 16;

/// A solid that moves: on which link, and where on it.
struct Part {
  std::uint32_t link;
  std::uint32_t group;  ///< of links that move as one: exempt among themselves
  Pose X_LS;
  AxisBox box_L;
  std::string owner, name;  ///< of a link or of a carried object
  bool is_carried;
};

/// The parts of one link, next to each other.
struct LinkParts {
  std::uint32_t link, group;
  std::uint32_t first, count;
  AxisBox box_L;
};

/// Two links that are checked against each other, and which of their parts.
struct LinkPair {
  std::uint32_t a, b;  ///< indices of LinkParts
  std::vector<SolidPair> parts;
};

struct ObstacleSolid {
  std::string owner, name;
  Pose X_WS;
  AxisBox box_W;
  Vector3 centre_W;
  double radius;
};

bool is_named(const std::string& name, const std::string& owner, const std::string& solid) {
  return name == owner || name == owner + "/" + solid;
}

AxisBox box_of(const Hexahedron& solid, const Pose& X) {
  std::array<Vector3, Hexahedron::kVertices> points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = transform(X, solid.vertices()[i]);
  AxisBox box = AxisBox::around(points);
  box.half.array() += (1.0 + 0x1p-50) * solid.radius();
  return box;
}

double largest_coordinate(const AxisBox& box) { return (box.centre.cwiseAbs() + box.half).maxCoeff(); }

/// No point of the box is nearer to p than this, to rounding; both in the box's frame.
double square_distance(const AxisBox& box, const Vector3& p) {
  const Vector3 out = ((p - box.centre).cwiseAbs() - box.half).cwiseMax(0.0);
  return dot(out, out);
}

/// By link: the first of those that fixed joints make one.
std::vector<std::uint32_t> rigid_groups(const Mechanism& mechanism) {
  std::vector<std::uint32_t> group(mechanism.links().size());
  std::iota(group.begin(), group.end(), 0u);
  for (const std::uint32_t j : mechanism.outwards()) {
    const Mechanism::Joint& joint = mechanism.joints()[j];
    if (joint.value == Mechanism::kNone) group[joint.outer] = group[joint.inner];
  }
  return group;
}

}  // namespace

struct ConfigurationCheck::Scratch::Memory {
  std::vector<TurnedBox> boxes;      ///< by LinkParts
  std::vector<Pose> X_WL, X_WS;      ///< by link; by solid of the narrowphase: parts, then obstacles
  std::vector<std::uint64_t> stamp;  ///< by part: the call that placed it
  std::uint64_t call = 0, asked = 0;
  std::array<SolidPair, kBlock> pairs;
  std::array<PairStatus, kBlock> status;
  std::size_t count = 0;
  std::unique_ptr<Narrowphase::Workspace> workspace;
};

struct ConfigurationCheck::State {
  ConfigurationScene scene;
  std::unique_ptr<Narrowphase> narrowphase;
  std::vector<Part> parts;
  std::vector<LinkParts> links;  ///< those that have any
  std::vector<LinkPair> link_pairs;
  std::vector<ObstacleSolid> obstacles;
  ObstacleTree tree;
  std::vector<std::uint8_t> exempt;  ///< by part and obstacle; empty: none is
  double reach = 0.0;                ///< the largest coordinate of obstacles, or of a link in its frame [m]
  double slack = 0.0;                ///< of coordinates up to 1 m

  using Memory = Scratch::Memory;

  // ---- set-up

  State(ConfigurationScene given, std::unique_ptr<Narrowphase> check)
      : scene(std::move(given)), narrowphase(std::move(check)) {
    if (!scene.mechanism) throw InputError("configuration check: no mechanism");
    if (!narrowphase) throw InputError("configuration check: no narrowphase");
    validate_pose(scene.X_WB, "configuration check: the base's pose");
    scene.X_WB = rigid_frame(scene.X_WB);
    slack = static_cast<double>(scene.mechanism->joints().size() + 8) * 0x1p-46;
    check_names();
    add_parts();
    add_obstacles();
    check_exemptions();
    pair_links();
    std::vector<Hexahedron> solids;
    for (const Part& part : parts) solids.push_back(solid_of(part));
    for (const Obstacle& obstacle : scene.obstacles)
      for (const PlacedHexahedron& placed : obstacle.tree->solids()) solids.push_back(placed.solid);
    narrowphase->build(solids);
  }

  void check_names() const {
    std::set<std::string> names;
    const auto take = [&](const std::string& name) {
      if (!names.insert(name).second)
        throw InputError("configuration check: the name '" + name + "' occurs twice");
    };
    for (const Mechanism::Link& link : scene.mechanism->links()) take(link.name);
    for (const CarriedObject& carried : scene.carried) {
      if (!carried.tree) throw InputError("configuration check: a carried object without a tree");
      validate_pose(carried.X_LO, "carried object '" + carried.tree->name() + "': pose");
      take(carried.tree->name());
    }
    for (const Obstacle& obstacle : scene.obstacles) {
      if (!obstacle.tree) throw InputError("configuration check: an obstacle without a tree");
      validate_pose(obstacle.X_WO, "obstacle '" + obstacle.tree->name() + "': pose");
      take(obstacle.tree->name());
    }
  }

  const Hexahedron& solid_of(const Part& part) const {
    const auto find = [&](const HexahedronTree& solids) -> const Hexahedron& {
      return std::find_if(solids.solids().begin(), solids.solids().end(),
                          [&](const PlacedHexahedron& placed) { return placed.name == part.name; })
          ->solid;
    };
    if (!part.is_carried) return find(*scene.mechanism->links()[part.link].tree);
    return find(*std::find_if(scene.carried.begin(), scene.carried.end(), [&](const CarriedObject& carried) {
                   return carried.tree->name() == part.owner;
                 })->tree);
  }

  void add_parts() {
    const Mechanism& mechanism = *scene.mechanism;
    const std::vector<std::uint32_t> group = rigid_groups(mechanism);
    for (std::uint32_t link = 0; link < mechanism.links().size(); ++link) {
      const auto first = static_cast<std::uint32_t>(parts.size());
      // add() appends the solids of one object as parts of the link.
      const auto add = [&](const HexahedronTree& object, const Pose& X_LO, const std::string& owner,
                           bool is_carried) {
        for (const PlacedHexahedron& placed : object.solids()) {
          // Of a link the product that forward kinematics uses, bit by bit.
          const Pose X_LS = is_carried ? compose(X_LO, placed.X_OS) : placed.X_OS;
          parts.push_back(
              {link, group[link], X_LS, box_of(placed.solid, X_LS), owner, placed.name, is_carried});
        }
      };
      // The solids of the link come first, then those that it carries.
      if (mechanism.links()[link].tree)
        add(*mechanism.links()[link].tree, {}, mechanism.links()[link].name, false);
      for (const CarriedObject& carried : scene.carried)
        if (mechanism.find_link(carried.link) == link)
          add(*carried.tree, carried.X_LO, carried.tree->name(), true);
      // The link's box holds all of its parts.
      const auto count = static_cast<std::uint32_t>(parts.size()) - first;
      if (count == 0) continue;
      AxisBox all = parts[first].box_L;
      for (std::uint32_t i = first; i < parts.size(); ++i) all = AxisBox::around(all, parts[i].box_L);
      links.push_back({link, group[link], first, count, all});
      reach = std::max(reach, largest_coordinate(all));
    }
    for (const CarriedObject& carried : scene.carried) mechanism.find_link(carried.link);  // or throws
  }

  void add_obstacles() {
    std::vector<AxisBox> boxes;
    for (const Obstacle& obstacle : scene.obstacles)
      for (const PlacedHexahedron& placed : obstacle.tree->solids()) {
        const Pose X_WS = compose(obstacle.X_WO, placed.X_OS);
        const Sphere& sphere = placed.solid.bounding_sphere();
        // A pose as given may stretch by kRotationTolerance.
        boxes.push_back(box_of(placed.solid, X_WS));
        obstacles.push_back({obstacle.tree->name(), placed.name, X_WS, boxes.back(),
                             transform(X_WS, sphere.centre),
                             sphere.radius * (1.0 + 2.0 * kRotationTolerance)});
        reach = std::max(reach, largest_coordinate(boxes.back()));
      }
    tree = ObstacleTree(std::move(boxes));
  }

  bool is_exempt(const ExemptPair& pair, const std::string& owner_a, const std::string& a,
                 const std::string& owner_b, const std::string& b) const {
    return (is_named(pair.first, owner_a, a) && is_named(pair.second, owner_b, b)) ||
           (is_named(pair.second, owner_a, a) && is_named(pair.first, owner_b, b));
  }

  void check_exemptions() {
    for (const ExemptPair& pair : scene.exempt) {
      int moving = 0;
      for (const std::string* name : {&pair.first, &pair.second}) {
        const auto is_it = [&](const auto& solid) { return is_named(*name, solid.owner, solid.name); };
        const bool moves = std::any_of(parts.begin(), parts.end(), is_it);
        if (!moves && std::none_of(obstacles.begin(), obstacles.end(), is_it))
          throw InputError("configuration check: exempt: '" + *name + "' names no link, tree or hexahedron");
        moving += moves;
      }
      if (moving == 0)
        throw InputError("configuration check: exempt: '" + pair.first + "' and '" + pair.second +
                         "' are both obstacles");
    }
    if (scene.exempt.empty()) return;
    exempt.assign(parts.size() * obstacles.size(), 0);
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t o = 0; o < obstacles.size(); ++o)
        for (const ExemptPair& pair : scene.exempt)
          if (is_exempt(pair, parts[p].owner, parts[p].name, obstacles[o].owner, obstacles[o].name))
            exempt[p * obstacles.size() + o] = 1;
  }

  bool are_checked(std::uint32_t a, std::uint32_t b) const {
    const Part &p = parts[a], &q = parts[b];
    if (p.group == q.group) return false;
    if (!p.is_carried && !q.is_carried &&
        scene.mechanism->is_exempt(index_in_mechanism(a), index_in_mechanism(b)))
      return false;
    return std::none_of(scene.exempt.begin(), scene.exempt.end(), [&](const ExemptPair& pair) {
      return is_exempt(pair, p.owner, p.name, q.owner, q.name);
    });
  }

  /// In Mechanism::solids(): the parts of a link come before what it carries.
  std::uint32_t index_in_mechanism(std::uint32_t part) const {
    const auto link = std::find_if(links.begin(), links.end(),
                                   [&](const LinkParts& each) { return each.link == parts[part].link; });
    return scene.mechanism->links()[parts[part].link].first_solid + (part - link->first);
  }

  void pair_links() {
    for (std::uint32_t a = 0; a < links.size(); ++a)
      for (std::uint32_t b = a + 1; b < links.size(); ++b) {
        LinkPair pair{a, b, {}};
        for (std::uint32_t p = links[a].first; p < links[a].first + links[a].count; ++p)
          for (std::uint32_t q = links[b].first; q < links[b].first + links[b].count; ++q)
            if (are_checked(p, q)) pair.parts.push_back({p, q});
        if (!pair.parts.empty()) link_pairs.push_back(std::move(pair));
      }
  }

  std::unique_ptr<Memory> make_memory() const {
    auto memory = std::make_unique<Memory>();
    memory->X_WL.resize(scene.mechanism->links().size());
    memory->X_WS.resize(parts.size());
    memory->boxes.resize(links.size());
    memory->stamp.resize(parts.size(), 0);
    for (const ObstacleSolid& obstacle : obstacles) memory->X_WS.push_back(obstacle.X_WS);
    memory->workspace = narrowphase->make_workspace();
    return memory;
  }

  // ---- one configuration

  /// Returns false once a pair is known that is not separated.
  bool ask(Memory& memory) const noexcept {
    if (memory.count == 0) return true;
    const std::span pairs(memory.pairs.data(), memory.count);
    const std::span status(memory.status.data(), memory.count);
    narrowphase->evaluate({pairs, memory.X_WS, {.kind = QueryKind::overlap}}, {status, {}, {}},
                          *memory.workspace);
    memory.asked += memory.count;
    memory.count = 0;
    return std::all_of(status.begin(), status.end(),
                       [](PairStatus each) { return each == PairStatus::separated; });
  }

  void place(std::uint32_t part, Memory& memory) const noexcept {
    if (memory.stamp[part] == memory.call) return;
    memory.stamp[part] = memory.call;
    memory.X_WS[part] = compose(memory.X_WL[parts[part].link], parts[part].X_LS);
  }

  bool add(std::uint32_t a, std::uint32_t b, Memory& memory) const noexcept {
    memory.pairs[memory.count++] = {a, b};
    return memory.count < kBlock || ask(memory);
  }

  /// The parts of a link against one obstacle whose box may meet theirs.
  bool look_at(const LinkParts& link, const TurnedBox& box, const Pose& X_WL, std::uint32_t obstacle,
               double allowed, Memory& memory) const noexcept {
    const ObstacleSolid& other = obstacles[obstacle];
    const auto seen = [&](const Vector3& p_W) {
      const Vector3 d = p_W - X_WL.p;
      return Vector3(dot(X_WL.R.col(0), d), dot(X_WL.R.col(1), d), dot(X_WL.R.col(2), d));
    };
    const Vector3 centre_L = seen(other.box_W.centre), sphere_L = seen(other.centre_W);
    const Vector3 half_L(dot(box.absolute.col(0), other.box_W.half),
                         dot(box.absolute.col(1), other.box_W.half),
                         dot(box.absolute.col(2), other.box_W.half));
    const double radius = other.radius + allowed;
    for (std::uint32_t p = link.first; p < link.first + link.count; ++p) {
      const AxisBox& part = parts[p].box_L;
      const Vector3 room = (centre_L - part.centre).cwiseAbs() - (part.half + half_L);
      if (room.x() > allowed || room.y() > allowed || room.z() > allowed) continue;
      if (square_distance(part, sphere_L) > radius * radius) continue;
      if (!exempt.empty() && exempt[p * obstacles.size() + obstacle]) continue;
      place(p, memory);
      if (!add(p, static_cast<std::uint32_t>(parts.size()) + obstacle, memory)) return false;
    }
    return true;
  }

  bool is_clear_of_obstacles(Memory& memory, double allowed) const noexcept {
    for (std::size_t i = 0; i < links.size(); ++i) {
      const LinkParts& link = links[i];
      if (link.group == base_group()) continue;
      const Pose& X_WL = memory.X_WL[link.link];
      const TurnedBox& box = memory.boxes[i];
      if (!tree.for_each(box, allowed, [&](std::uint32_t obstacle) {
            return look_at(link, box, X_WL, obstacle, allowed, memory);
          }))
        return false;
    }
    return true;
  }

  std::uint32_t base_group() const noexcept { return scene.mechanism->base(); }

  bool is_clear_of_itself(Memory& memory, double allowed) const noexcept {
    for (const LinkPair& pair : link_pairs) {
      const LinkParts &a = links[pair.a], &b = links[pair.b];
      if (!may_meet(memory.boxes[pair.a], memory.boxes[pair.b], allowed)) continue;
      const Pose X_AB = compose(inverse(memory.X_WL[a.link]), memory.X_WL[b.link]);
      for (const SolidPair& each : pair.parts) {
        const TurnedBox box(parts[each.b].box_L, X_AB.R, X_AB.p);
        if (!may_meet(parts[each.a].box_L, box, allowed)) continue;
        place(each.a, memory), place(each.b, memory);
        if (!add(each.a, each.b, memory)) return false;
      }
    }
    return true;
  }

  bool is_free(std::span<const double> q, Memory& memory) const noexcept {
    for (const double value : q)
      if (!std::isfinite(value)) return false;
    ++memory.call;
    memory.count = 0;
    scene.mechanism->link_poses(scene.X_WB, q, memory.X_WL);
    double scale = reach;
    for (const Pose& X : memory.X_WL) scale = std::max(scale, norm_inf(X.p));
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Pose& X_WL = memory.X_WL[links[i].link];
      memory.boxes[i] = TurnedBox(links[i].box_L, X_WL.R, X_WL.p);
    }
    const double allowed = slack * (4.0 * scale);  // differences, over three axes, are no larger
    return is_clear_of_itself(memory, allowed) && is_clear_of_obstacles(memory, allowed) && ask(memory);
  }
};

ConfigurationCheck::ConfigurationCheck(ConfigurationScene scene, std::unique_ptr<Narrowphase> narrowphase)
    : state_(std::make_unique<const State>(std::move(scene), std::move(narrowphase))) {}
ConfigurationCheck::~ConfigurationCheck() = default;

const Mechanism& ConfigurationCheck::mechanism() const { return *state_->scene.mechanism; }

ConfigurationCheck::Scratch::Scratch(std::unique_ptr<Memory> memory) : memory_(std::move(memory)) {}
ConfigurationCheck::Scratch::~Scratch() = default;
ConfigurationCheck::Scratch::Scratch(Scratch&&) noexcept = default;
ConfigurationCheck::Scratch& ConfigurationCheck::Scratch::operator=(Scratch&&) noexcept = default;
std::uint64_t ConfigurationCheck::Scratch::pairs_asked() const { return memory_->asked; }

ConfigurationCheck::Scratch ConfigurationCheck::make_scratch() const {
  return Scratch(state_->make_memory());
}

bool ConfigurationCheck::is_free(std::span<const double> q, Scratch& scratch) const noexcept {
  return state_->is_free(q, *scratch.memory_);
}

std::size_t ConfigurationCheck::are_free(std::span<const double> configurations, std::span<std::uint8_t> out,
                                         Scratch& scratch) const noexcept {
  const std::size_t values = mechanism().value_count();
  std::size_t free = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = is_free(configurations.subspan(i * values, values), scratch) ? 1 : 0;
    free += out[i];
  }
  return free;
}

}  // namespace touchstone
