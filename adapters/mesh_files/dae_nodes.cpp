#include "touchstone/adapters/mesh_files/dae_nodes.hpp"

#include <map>
#include <string>
#include <vector>

namespace touchstone::mesh_files {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

/// The value of an attribute of a tag; empty where it has none.
std::string_view attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    if (at == 0 || kBlanks.find(tag[at - 1]) == std::string_view::npos) continue;
    const std::size_t equals = tag.find_first_not_of(kBlanks, at + name.size());
    if (equals == std::string_view::npos || tag[equals] != '=') continue;
    const std::size_t open = tag.find_first_of("'\"", equals);
    if (open == std::string_view::npos) return {};
    return tag.substr(open + 1, tag.find(tag[open], open + 1) - open - 1);
  }
  return {};
}

bool is_element(std::string_view tag, std::string_view name) {
  return tag.starts_with(name) && (tag.size() == name.size() || tag[name.size()] == '/' ||
                                   kBlanks.find(tag[name.size()]) != kBlanks.npos);
}

/// Which nodes a node holds or instances, by id and by name: assimp takes either.
struct Nodes {
  std::vector<std::vector<std::size_t>> held;
  std::vector<std::vector<std::string>> instanced;
  std::multimap<std::string, std::size_t, std::less<>> by_name;
};

Nodes nodes_of(std::string_view text) {
  Nodes out;
  std::vector<std::size_t> open;
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    // A comment may hold tags, so it is skipped whole.
    const bool is_comment = text.substr(at).starts_with("<!--");
    const std::size_t end = text.find(is_comment ? "-->" : ">", at);
    if (end == std::string_view::npos) break;
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    at = end;
    if (is_comment) continue;
    // A node is held by the one that is open around it.
    if (is_element(tag, "/node")) {
      if (!open.empty()) open.pop_back();
    } else if (is_element(tag, "node")) {
      const std::size_t node = out.held.size();
      out.held.emplace_back();
      out.instanced.emplace_back();
      // Others refer to a node by any of its names.
      for (const std::string_view name :
           {attribute(tag, "id"), attribute(tag, "name"), attribute(tag, "sid")})
        if (!name.empty()) out.by_name.emplace(name, node);
      if (!open.empty()) out.held[open.back()].push_back(node);
      if (!tag.ends_with('/')) open.push_back(node);
    } else if (is_element(tag, "instance_node") && !open.empty()) {
      // An instance may come before its node in the file, so only its name is kept.
      std::string_view url = attribute(tag, "url");
      if (url.starts_with('#')) url.remove_prefix(1);
      out.instanced[open.back()].emplace_back(url);
    }
  }
  return out;
}

std::vector<std::size_t> next_of(const Nodes& nodes, std::size_t node) {
  std::vector<std::size_t> out = nodes.held[node];
  for (const std::string& name : nodes.instanced[node]) {
    const auto [first, last] = nodes.by_name.equal_range(name);
    for (auto found = first; found != last; ++found) out.push_back(found->second);
  }
  return out;
}

}  // namespace

void require_finite_nodes(std::string_view text, const ReadTask& task) {
  const Nodes nodes = nodes_of(text);
  // Depth first, without recursion: a node that is still open is reached again by a cycle alone.
  enum class State : unsigned char { unseen, open, done };
  std::vector<State> state(nodes.held.size(), State::unseen);
  struct Step {
    std::size_t node;
    std::vector<std::size_t> rest;
  };
  // Each node not seen so far begins a search.
  for (std::size_t first = 0; first < state.size(); ++first) {
    std::vector<Step> path;
    const auto enter = [&](std::size_t node) {
      state[node] = State::open;
      path.push_back({node, next_of(nodes, node)});
    };
    if (state[first] == State::unseen) enter(first);
    // The last node goes on to its next one, or is done.
    while (!path.empty()) {
      if (path.back().rest.empty()) {
        state[path.back().node] = State::done;
        path.pop_back();
        continue;
      }
      const std::size_t node = path.back().rest.back();
      path.back().rest.pop_back();
      if (state[node] == State::open) {
        for (const auto& [name, named] : nodes.by_name)
          if (named == node) task.fail("node '" + name + "' instances itself, by others or at once");
        task.fail("a node instances itself, by others or at once");
      }
      if (state[node] == State::unseen) enter(node);
    }
  }
}

}  // namespace touchstone::mesh_files
