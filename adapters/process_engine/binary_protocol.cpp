#include <algorithm>
#include <cstring>

#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/process_engine/protocol.hpp"

namespace touchstone::process_engine {
namespace {

/// Before every message to the engine.
struct Head {
  std::uint32_t kind;  ///< 1: solids, 2: pairs
  std::uint32_t count;
  std::uint32_t batch = 0;
  std::uint32_t query = 0;
  std::uint32_t max_points = 0;
  std::uint32_t reserved = 0;
  double max_separation = 0.0;
  double max_point_separation = 0.0;
};
static_assert(sizeof(Head) == 40);

struct PairRecord {
  SolidPair pair;
  Pose X_WA, X_WB;
};
static_assert(sizeof(PairRecord) == 200);

/// Before every reply, and at the head of every answer in it: its pair's number, its status.
struct TwoWords {
  std::uint32_t first, second;
};

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
T read_at(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(static_cast<void*>(&value), bytes.data() + at, sizeof value);
  return value;
}

std::size_t answer_bytes(const Query& query) {
  return sizeof(TwoWords) + (query.kind == QueryKind::overlap ? 0 : sizeof(touchstone_geometry)) +
         query.slots() * sizeof(touchstone_point);
}

class BinaryProtocol final : public Protocol {
 public:
  std::size_t largest_question() const override { return 4096; }

  void write_solids(std::span<const double> corners, std::string& out) const override {
    append(out, Head{1, static_cast<std::uint32_t>(corners.size() / 24)});
    out.append(reinterpret_cast<const char*>(corners.data()), corners.size_bytes());
  }

  void write_question(const Question& question, std::string& out) const override {
    const NarrowphaseInput& input = question.input;
    append(out,
           Head{2, static_cast<std::uint32_t>(question.pairs.size()), question.batch,
                static_cast<std::uint32_t>(input.query.kind), static_cast<std::uint32_t>(input.query.slots()),
                0, input.query.max_separation, input.query.max_point_separation});
    const std::size_t before = out.size();
    out.resize(before + question.pairs.size() * sizeof(PairRecord));
    char* to = out.data() + before;
    for (const std::uint32_t i : question.pairs) {
      const SolidPair pair = input.pairs[i];
      std::memcpy(to, &pair, sizeof pair);
      std::memcpy(to + sizeof pair, input.poses[pair.a].R.data(), sizeof(Pose));
      std::memcpy(to + sizeof pair + sizeof(Pose), input.poses[pair.b].R.data(), sizeof(Pose));
      to += sizeof(PairRecord);
    }
  }

  std::size_t wanted(const Question& question, std::string_view reply) const override {
    const std::size_t whole = sizeof(TwoWords) + question.pairs.size() * answer_bytes(question.input.query);
    return whole - std::min(whole, reply.size());
  }

  Decoded read_reply(const Question& question, std::string_view reply,
                     const NarrowphaseOutput& output) const override {
    const Query& query = question.input.query;
    if (reply.size() < sizeof(TwoWords)) return {0, "its reply is short"};
    const auto head = read_at<TwoWords>(reply, 0);
    if (head.first != question.batch) return {0, "its reply is to another question"};
    if (head.second != question.pairs.size()) return {0, "its reply announces another number of answers"};
    std::size_t at = sizeof(TwoWords);
    for (std::size_t k = 0; k < question.pairs.size(); ++k, at += answer_bytes(query)) {
      if (reply.size() - at < answer_bytes(query)) return {k, "its reply is short"};
      const auto answer = read_at<TwoWords>(reply, at);
      if (answer.first != k) return {k, "its answers are in another order than the pairs"};
      const std::uint32_t i = question.pairs[k];
      output.status[i] = static_cast<PairStatus>(std::min(answer.second, 255u));
      if (query.kind == QueryKind::overlap) continue;
      std::memcpy(static_cast<void*>(&output.geometry[i]), reply.data() + at + sizeof(TwoWords),
                  sizeof(touchstone_geometry));
      if (query.slots() > 0)
        std::memcpy(static_cast<void*>(&output.points[i * query.slots()]),
                    reply.data() + at + sizeof(TwoWords) + sizeof(touchstone_geometry),
                    query.slots() * sizeof(touchstone_point));
    }
    return {question.pairs.size(), nullptr};
  }
};

}  // namespace

std::unique_ptr<Protocol> make_binary_protocol() { return std::make_unique<BinaryProtocol>(); }

}  // namespace touchstone::process_engine
