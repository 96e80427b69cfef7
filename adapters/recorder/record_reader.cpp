#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>

#include "touchstone/adapters/recorder/csv_text.hpp"
#include "touchstone/adapters/recorder/recorder.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace recorder;

/// Lines of fields as RFC 4180 has them. A last line without its end is not given: it was cut off.
class CsvReader {
 public:
  explicit CsvReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_ || std::filesystem::is_directory(path))
      throw InputError("record '" + path + "': cannot be opened");
  }

  const std::vector<std::string>& fields() const { return fields_; }

  bool next() {
    line_ = next_line_;
    fields_.assign(1, {});
    std::streambuf& in = *file_.rdbuf();
    bool is_quoted = false;
    for (int c = in.sbumpc(); c != std::char_traits<char>::eof(); c = in.sbumpc()) {
      if (c == '\n') ++next_line_;
      if (c == '"') {
        // Within quotes two stand for one.
        if (is_quoted && in.sgetc() == '"') {
          fields_.back() += static_cast<char>(in.sbumpc());
        } else {
          is_quoted = !is_quoted;
        }
      } else if (c == ',' && !is_quoted) {
        fields_.emplace_back();
      } else if (c == '\n' && !is_quoted) {
        return true;
      } else {
        fields_.back() += static_cast<char>(c);
      }
    }
    return false;
  }

  [[noreturn]] void reject(const std::string& reason) const {
    throw InputError("record '" + path_ + "', line " + std::to_string(line_) + ": " + reason);
  }

  template <class Number>
  Number number(int column) const {
    const std::string& field = fields_[static_cast<std::size_t>(column)];
    Number value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size())
      reject("'" + field + "' is no number that fits");
    return value;
  }

 private:
  std::string path_;
  std::ifstream file_;
  std::vector<std::string> fields_;
  std::size_t line_ = 1, next_line_ = 1;
};

/// Turns lines into a recording.
class RecordParser {
 public:
  explicit RecordParser(CsvReader& in) : in_(in) {}

  Recording parse() {
    check_header();
    while (in_.next()) take_line();
    if (missing_rows_ > 0) recording_.frames.pop_back();  // it was cut off
    recording_.lost_after = lost_;
    return std::move(recording_);
  }

 private:
  void check_header() {
    std::string header;
    if (in_.next()) {
      for (const std::string& field : in_.fields()) header += (header.empty() ? "" : ",") + field;
    }
    if (header != kHeader) in_.reject("no record: the first line does not name its columns");
  }

  void take_line() {
    // A line has all columns, and nothing follows the end.
    if (in_.fields().size() != kColumns) {
      in_.reject(std::to_string(in_.fields().size()) + " fields instead of " + std::to_string(kColumns));
    }
    if (recording_.is_complete) in_.reject("something follows the end");
    // Poses and events belong to the frame before them.
    const std::string& record = in_.fields()[kRecord];
    const auto frame = in_.number<std::uint64_t>(kFrame);
    if (record == "pose" || record == "event") return take_row(record, frame);
    // All other records wait until the frame has its lines.
    if (missing_rows_ > 0)
      in_.reject("frame " + std::to_string(recording_.frames.back().frame) + " misses " +
                 std::to_string(missing_rows_) + " of its lines");
    if (record == "lost") {
      lost_ += in_.number<std::uint64_t>(kCount);
    } else if (record == "frame") {
      recording_.frames.push_back({frame, in_.number<double>(kTime), lost_, {}, {}});
      lost_ = 0;
      missing_rows_ = in_.number<std::uint64_t>(kCount);
    } else if (record == "end") {
      recording_.is_complete = true;
      if (in_.number<std::uint64_t>(kCount) != recording_.frames.size())
        in_.reject("the end tells of " + in_.fields()[kCount] + " frames, there are " +
                   std::to_string(recording_.frames.size()));
    } else {
      in_.reject("unknown record '" + record + "'");
    }
  }

  void take_row(const std::string& record, std::uint64_t frame) {
    if (missing_rows_ == 0 || recording_.frames.back().frame != frame)
      in_.reject("a line of frame " + std::to_string(frame) + " outside of it");
    --missing_rows_;
    RecordedFrame& into = recording_.frames.back();
    if (record == "pose") {
      into.poses.push_back(pose());
    } else {
      into.events.push_back(event());
    }
  }

  RecordedPose pose() {
    RecordedPose pose{object(kObject), {}};
    for (int i = 0; i < 9; ++i) pose.X_WO.R(i / 3, i % 3) = in_.number<double>(kPose + i);
    for (int i = 0; i < 3; ++i) pose.X_WO.p(i) = in_.number<double>(kPose + 9 + i);
    return pose;
  }

  RecordedEvent event() {
    RecordedEvent event;
    event.kind = kind();
    event.a = object(kObject);
    event.b = in_.fields()[kOther].empty() ? RecordedEvent::kNone : object(kOther);
    event.solids = {in_.number<SolidIndex>(kSolid), in_.number<SolidIndex>(kOtherSolid)};
    event.part = in_.number<std::uint32_t>(kPart);
    event.s = in_.number<double>(kS);
    event.geometry = geometry(kSeparation);
    event.geometry_at_end = geometry(kEndSeparation);
    return event;
  }

  PairGeometry geometry(int column) {
    return {in_.number<double>(column), vector(column + 1), vector(column + 4), vector(column + 7), 0};
  }

  Vector3 vector(int column) const {
    return {in_.number<double>(column), in_.number<double>(column + 1), in_.number<double>(column + 2)};
  }

  EventKind kind() const {
    for (int i = 0; i <= static_cast<int>(EventKind::at_limit); ++i)
      if (to_string(static_cast<EventKind>(i)) == in_.fields()[kEvent]) return static_cast<EventKind>(i);
    in_.reject("unknown event '" + in_.fields()[kEvent] + "'");
  }

  std::uint32_t object(int column) {
    const std::string& name = in_.fields()[static_cast<std::size_t>(column)];
    if (name.empty()) in_.reject("no object");
    std::vector<std::string>& names = recording_.objects;
    // Frames list their objects in the same order: the one after the last is the likely one.
    if (++last_ < names.size() && names[last_] == name) return static_cast<std::uint32_t>(last_);
    const auto place = std::find(names.begin(), names.end(), name);
    last_ = static_cast<std::size_t>(place - names.begin());
    if (place == names.end()) names.push_back(name);
    return static_cast<std::uint32_t>(last_);
  }

  CsvReader& in_;
  Recording recording_;
  std::uint64_t lost_ = 0;
  std::uint64_t missing_rows_ = 0;  // of the last frame
  std::size_t last_ = 0;
};

}  // namespace

Recording read_recording(const std::string& path) {
  CsvReader in(path);
  return RecordParser(in).parse();
}

}  // namespace touchstone
