#include "touchstone/examples/compare_backends/run/shards/shard_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json_error.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::comparison {
namespace {

namespace fs = std::filesystem;

/// A head is a line of some kilobytes; what has none in its first bytes is no shard.
constexpr std::size_t kLongestHead = std::size_t{1} << 24;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw InputError("merge: " + path + ": " + what);
}

/// The text up to the first line end; empty where there is no line end.
std::string first_line(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  for (char c = 0; line.size() < kLongestHead && stream.get(c);) {
    if (c == '\n') return line;
    line += c;
  }
  return {};
}

bool is_shard_file(const fs::path& path) {
  return first_line(path.string()).find(kShardSchema) != std::string::npos;
}

/// Something stands there that is no shard's file.
bool is_taken(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error)) &&
         !(fs::is_regular_file(path, error) && is_shard_file(path));
}

/// The files that a run reads beside the families, each by its option and with its SHA-256.
Json inputs_of(const Options& options) {
  Json inputs = Json::object();
  const auto add = [&](const std::string& option, const std::string& file) {
    if (!file.empty()) inputs[option + " " + file] = sha256(read_file(file, option));
  };
  add(options.is_capture ? "--capture" : "--pairs", options.pairs_file);
  if (!options.corpus.empty()) add("--corpus", (fs::path(options.corpus) / kCorpusManifest).string());
  add("--dynamics", options.dynamics_file);
  for (const std::string& scene : options.scenes) add("--scene", scene);
  return inputs;
}

Json backends_of(const Report& report) {
  Json backends = Json::array();
  for (const auto& [name, description] : report.backends) backends.push_back(name + ": " + description);
  return backends;
}

/// The first entry of a list or object in which the two differ, for an error.
std::string difference(const Json& first, const Json& second) {
  const Json apart = Json::diff(first, second);
  const std::string place = apart.empty() ? "" : apart.at(0).at("path").get<std::string>();
  const auto text = [&](const Json& in) {
    const Json::json_pointer at(place);
    return in.contains(at) ? one_line(in.at(at)) : std::string("nothing");
  };
  return text(second) + " in place of " + text(first);
}

/// Names and cases of all sets.
Json sets_in(const Json& head) {
  Json sets = Json::array();
  for (const Json& set : head.at("sets")) sets.push_back({set.at("name"), set.at("cases")});
  return sets;
}

std::string bytes_at(const std::string& path, std::size_t begin, std::size_t size) {
  std::ifstream stream(path, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(begin));
  std::string bytes(size, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

/// Reads the answers of an entry of the head's sets; refuses those to other cases than the shard has.
SetAnswers read_set(const std::string& path, const Json& head, Shard shard, const Json& set,
                    std::string bytes) {
  const auto name = set.at("name").get<std::string>();
  try {
    SetAnswers part = decode_set(std::move(bytes));
    check_part(part, shard.cases_of(set.at("cases")), head.at("exact"));
    // A pair file's own answers stand behind those of the backends.
    const std::size_t backends = head.at("backends").size();
    if (part.answers.size() != backends && part.answers.size() != backends + 1)
      throw std::runtime_error("has answers of other backends than its head");
    return part;
  } catch (const std::runtime_error& wrong) {
    refuse(path, "its set '" + name + "' " + wrong.what());
  }
}

/// Reads each value of the head once, as what it must be.
/// @throws nlohmann::json::exception for the first that is not.
void check_kinds(const Json& head) {
  for (const char* what : {"version", "layout"}) head.at(what).get_ref<const std::string&>();
  for (const char* what : {"cpu", "instruction_set", "compiler", "build_type", "flags"})
    head.at("machine").at(what).get_ref<const std::string&>();
  head.at("arguments").get<std::vector<std::string>>();
  head.at("inputs").get_ref<const Json::object_t&>();
  head.at("backends").get_ref<const Json::array_t&>();
  head.at("exact").get_ref<const bool&>();
  head.at("engine_messages").get_ref<const Json::number_unsigned_t&>();
  for (const std::size_t i : {0u, 1u}) head.at("shard").at(i).get_ref<const Json::number_unsigned_t&>();
  for (const Json& set : head.at("sets").get_ref<const Json::array_t&>()) {
    set.at("name").get_ref<const std::string&>();
    set.at("sha256").get_ref<const std::string&>();
    set.at("cases").get_ref<const Json::number_unsigned_t&>();
    set.at("bytes").get_ref<const Json::number_unsigned_t&>();
  }
}

}  // namespace

std::string shard_name(Shard shard) { return fmt::format("shard_{}_of_{}.bin", shard.k, shard.n); }

// ---- writing

ShardWriter::ShardWriter(fs::path folder, Shard shard, std::vector<std::string> arguments)
    : file_(std::move(folder) / shard_name(shard)), shard_(shard), arguments_(std::move(arguments)) {
  if (is_taken(file_))
    throw InputError("--output: " + file_.string() +
                     ": is there, and no shard of a run: name another folder");
  std::error_code error;
  if (file_.has_parent_path()) fs::create_directories(file_.parent_path(), error);
  partial_ = file_.string() + fmt::format(".{}.part", getpid());
  const bool can_write = std::ofstream(partial_, std::ios::binary).is_open();
  fs::remove(partial_, error);
  if (!can_write)
    throw InputError("--output: " + file_.string() + ": cannot be written: name a folder that can be");
}

void ShardWriter::add(const std::string& set, std::size_t cases, const SetAnswers& part) {
  const std::string bytes = encode_set(part);
  sets_.push_back({{"name", set}, {"cases", cases}, {"bytes", bytes.size()}, {"sha256", sha256(bytes)}});
  bytes_ += bytes;
}

fs::path ShardWriter::finish(const Report& report) {
  Json head = {{"schema", kShardSchema},
               {"version", report.machine.version},
               {"layout", set_layout()},
               {"machine", json(report.machine)},
               {"shard", {shard_.k, shard_.n}},
               {"arguments", arguments_},
               {"inputs", inputs_of(report.options)},
               {"backends", backends_of(report)},
               {"exact", report.has_truth},
               {"engine_messages", report.engine_messages},
               {"sets", sets_}};
  std::error_code error;
  std::ofstream stream(partial_, std::ios::binary);
  stream << one_line(head) << '\n' << bytes_;
  stream.close();
  // The measurements are kept under another name.
  if (stream && is_taken(file_))
    throw std::runtime_error(file_.string() +
                             ": was put there meanwhile, and is no shard of a run: this one is " +
                             partial_.string());
  if (stream) fs::rename(partial_, file_, error);
  if (!stream || error) {
    fs::remove(partial_, error);
    throw std::runtime_error(file_.string() +
                             " cannot be written: is the folder there, and the disk not full?");
  }
  return file_;
}

// ---- reading

ShardAnswers::File ShardAnswers::read_head(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) refuse(path, "there is no such file");
  const std::string line = first_line(path);
  if (line.find(kShardSchema) == std::string::npos)
    refuse(path, "is no shard of a run (compare_backends --shard)");
  File file{path, {}, {}, line.size() + 1};
  try {
    file.head = Json::parse(line);
    check_kinds(file.head);
    file.shard = {file.head.at("shard").at(0), file.head.at("shard").at(1)};
  } catch (const nlohmann::json::exception& wrong) {
    refuse(path, "its head " + reason_of(wrong));
  }
  if (file.shard.k < 1 || file.shard.k > file.shard.n || file.shard.n > kMostShards)
    refuse(path, "is of no shard: " + file.shard.text());
  check_build(file);
  check_sets(file);
  return file;
}

void ShardAnswers::check_build(const File& file) {
  const auto hold = [&](const Json& in, const char* what, const char* named, const std::string& here) {
    const std::string there = in.at(what);
    if (there != here) refuse(file.path, fmt::format("is of {} {}, this is {}", named, there, here));
  };
  const Machine here = describe_machine();
  hold(file.head, "version", "version", here.version);
  hold(file.head, "layout", "layout", set_layout());
  hold(file.head.at("machine"), "build_type", "build type", here.build_type);
  hold(file.head.at("machine"), "flags", "flags", here.flags);
}

void ShardAnswers::check_sets(const File& file) {
  std::error_code error;
  const std::uintmax_t file_size = fs::file_size(file.path, error);
  if (error) refuse(file.path, "cannot be read");
  std::size_t at = file.sets_begin;
  for (const Json& set : file.head.at("sets")) {
    const std::size_t size = set.at("bytes");
    const std::string bytes = at > file_size || size > file_size - at ? "" : bytes_at(file.path, at, size);
    if (bytes.size() != size || sha256(bytes) != set.at("sha256"))
      refuse(file.path, "is cut off or changed: the set '" + set.at("name").get<std::string>() +
                            "' has not the SHA-256 of its head");
    read_set(file.path, file.head, file.shard, set, bytes);
    at += size;
  }
  if (at != file_size) refuse(file.path, "has more than its head says");
}

ShardAnswers::ShardAnswers(const std::vector<std::string>& files) {
  for (const std::string& path : files) files_.push_back(read_head(path));
  check_same_run();
  std::stable_sort(files_.begin(), files_.end(),
                   [](const File& x, const File& y) { return x.shard.k < y.shard.k; });
  drop_repeated();
  check_whole();
}

void ShardAnswers::check_same_run() const {
  const File& first = files_.front();
  for (const File& file : files_) {
    for (const char* what : {"arguments", "inputs", "backends", "exact"})
      if (file.head.at(what) != first.head.at(what))
        refuse(file.path, fmt::format("is of another run than {}: its {} have {}", first.path, what,
                                      difference(first.head.at(what), file.head.at(what))));
    if (file.shard.n != first.shard.n)
      refuse(file.path, fmt::format("is shard {} and overlaps {}, which is shard {}: a run is cut one way",
                                    file.shard.text(), first.path, first.shard.text()));
    if (sets_in(file.head) != sets_in(first.head)) refuse(file.path, "has other sets than " + first.path);
  }
}

void ShardAnswers::drop_repeated() {
  for (std::size_t i = 1; i < files_.size();) {
    const File &before = files_[i - 1], &here = files_[i];
    if (before.shard != here.shard) {
      ++i;
      continue;
    }
    if (before.head != here.head)
      refuse(here.path, fmt::format("is shard {}, which {} is too, from another try: name one of them",
                                    here.shard.text(), before.path));
    files_.erase(files_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void ShardAnswers::check_whole() const {
  const std::size_t n = files_.front().shard.n;
  if (files_.size() == n) return;
  std::string missing;
  std::size_t next = 0, named = 0;
  for (std::size_t k = 1; k <= n; ++k) {
    if (next < files_.size() && files_[next].shard.k == k)
      ++next;
    else if (++named <= 20)
      missing += " " + Shard{k, n}.text();
  }
  throw InputError("merge: lost:" + missing + (named > 20 ? fmt::format(" and {} more", named - 20) : ""));
}

std::vector<std::string> ShardAnswers::arguments() const { return files_.front().head.at("arguments"); }

void ShardAnswers::check(const Report& report) const {
  const Json& head = files_.front().head;
  const auto hold = [&](const char* what, const Json& here) {
    if (head.at(what) != here)
      refuse(files_.front().path,
             fmt::format("its {} are not those of here: {}", what, difference(head.at(what), here)));
  };
  hold("inputs", inputs_of(report.options));
  hold("backends", backends_of(report));
  hold("exact", report.has_truth);
}

std::size_t ShardAnswers::engine_messages() const {
  std::size_t lines = 0;
  for (const File& file : files_) lines += file.head.at("engine_messages").get<std::size_t>();
  return lines;
}

std::vector<ShardMachine> ShardAnswers::elsewhere(const Machine& here) const {
  std::vector<ShardMachine> shards;
  for (const File& file : files_) {
    const Json& machine = file.head.at("machine");
    ShardMachine of{file.shard, machine.at("cpu"), machine.at("instruction_set"), machine.at("compiler")};
    if (of.cpu != here.cpu || of.instruction_set != here.instruction_set || of.compiler != here.compiler)
      shards.push_back(std::move(of));
  }
  return shards;
}

SetAnswers ShardAnswers::of(const PairSet& set, bool with_points) const {
  std::vector<SetAnswers> parts;
  for (const File& file : files_) {
    std::size_t at = file.sets_begin;
    for (const Json& each : file.head.at("sets")) {
      const std::size_t size = each.at("bytes");
      if (each.at("name") == set.name) {
        if (each.at("cases") != set.pairs.size()) refuse(file.path, "has other cases of '" + set.name + "'");
        parts.push_back(read_set(file.path, file.head, file.shard, each, bytes_at(file.path, at, size)));
        if (parts.back().answers.size() != parts.front().answers.size())
          refuse(file.path, "has answers of other backends than " + files_.front().path);
        for (const BackendAnswers& backend : parts.back().answers) {
          const QueryAnswers& manifold = backend.queries[index_of(QueryKind::manifold)];
          if (with_points && manifold.points.empty() && !manifold.status.empty())
            refuse(file.path, "has no contact points of '" + set.name + "'");
        }
        break;
      }
      at += size;
    }
  }
  if (parts.size() != files_.size()) refuse(files_.front().path, "has no set '" + set.name + "'");
  return joined_parts(parts, set.pairs.size());
}

}  // namespace touchstone::comparison
