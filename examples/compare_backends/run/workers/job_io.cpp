#include "touchstone/examples/compare_backends/run/workers/job_io.hpp"

#include <array>

namespace touchstone::comparison {
namespace {

using Numbers3 = std::array<double, 3>;

void put(ByteWriter& out, const Vector3& v) { out.put(Numbers3{v.x(), v.y(), v.z()}); }

void get(ByteReader& in, Vector3& v) {
  Numbers3 numbers;
  in.get(numbers);
  v = {numbers[0], numbers[1], numbers[2]};
}

void put(ByteWriter& out, const Pose& pose) {
  for (int column = 0; column < 3; ++column) put(out, Vector3(pose.R.col(column)));
  put(out, pose.p);
}

void get(ByteReader& in, Pose& pose) {
  Vector3 column;
  for (int i = 0; i < 3; ++i) {
    get(in, column);
    pose.R.col(i) = column;
  }
  get(in, pose.p);
}

void put(ByteWriter& out, const Hexahedron& solid) {
  refuse_rounded({&solid, 1}, "comparison");
  out.put(solid.is_box());
  if (solid.is_box()) return put(out, solid.half_extents());
  for (const Vector3& vertex : solid.vertices()) put(out, vertex);
}

Hexahedron get_solid(ByteReader& in) {
  bool is_box = false;
  in.get(is_box);
  if (is_box) {
    Vector3 half;
    get(in, half);
    return Hexahedron::from_size(half * 2);
  }
  std::array<Vector3, 8> vertices;
  for (Vector3& vertex : vertices) get(in, vertex);
  return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
}

void put(ByteWriter& out, const PairGeometry& geometry) {
  out.put(geometry.separation);
  put(out, geometry.n_AB_W);
  put(out, geometry.p_A_W);
  put(out, geometry.p_B_W);
  out.put(geometry.point_count);
}

void get(ByteReader& in, PairGeometry& geometry) {
  in.get(geometry.separation);
  get(in, geometry.n_AB_W);
  get(in, geometry.p_A_W);
  get(in, geometry.p_B_W);
  in.get(geometry.point_count);
}

void put(ByteWriter& out, const ContactPoint& point) {
  put(out, point.p_A_W);
  put(out, point.p_B_W);
  out.put(point.separation);
  out.put(point.feature_id);
}

void get(ByteReader& in, ContactPoint& point) {
  get(in, point.p_A_W);
  get(in, point.p_B_W);
  in.get(point.separation);
  in.get(point.feature_id);
}

void put(ByteWriter& out, const measures::LaterAnswer& answer);
void get(ByteReader& in, measures::LaterAnswer& answer);

template <typename T>
void put_each(ByteWriter& out, const std::vector<T>& items) {
  out.put(items.size());
  for (const T& item : items) put(out, item);
}

template <typename T>
void get_each(ByteReader& in, std::vector<T>& items) {
  for (std::size_t i = in.get_count(); i > 0; --i) get(in, items.emplace_back());
}

template <typename T>
void put_optional(ByteWriter& out, const std::optional<T>& value) {
  out.put(value.has_value());
  if (value) out.put(*value);
}

template <typename T>
void get_optional(ByteReader& in, std::optional<T>& value) {
  bool present = false;
  in.get(present);
  if (!present) return;
  in.get(value.emplace());
}

void put(ByteWriter& out, const measures::LaterAnswer& answer) {
  out.put(answer.index);
  out.put(answer.status);
  put(out, answer.geometry);
  put_each(out, answer.points);
}

void get(ByteReader& in, measures::LaterAnswer& answer) {
  in.get(answer.index);
  in.get(answer.status);
  get(in, answer.geometry);
  get_each(in, answer.points);
}

void put(ByteWriter& out, const QueryAnswers& answers) {
  out.put_list(answers.status);
  put_each(out, answers.geometry);
  put_each(out, answers.points);
  put_optional(out, answers.single);
  put_optional(out, answers.batch);
  put_optional(out, answers.raw);
  put_optional(out, answers.cached);
  put_optional(out, answers.allocations);
  put_each(out, answers.later);
}

void get(ByteReader& in, QueryAnswers& answers) {
  in.get_list(answers.status);
  get_each(in, answers.geometry);
  get_each(in, answers.points);
  get_optional(in, answers.single);
  get_optional(in, answers.batch);
  get_optional(in, answers.raw);
  get_optional(in, answers.cached);
  get_optional(in, answers.allocations);
  get_each(in, answers.later);
}

}  // namespace

std::string encode_job(const Job& job) {
  ByteWriter out;
  out.put_list(job.backends);
  out.put(job.options);
  out.put(job.set.name);
  out.put(job.set.solids.size());
  for (const Hexahedron& solid : job.set.solids) put(out, solid);
  out.put_list(job.set.pairs);
  put_each(out, job.set.poses);
  out.put_list(job.set.exact_separations);
  return out.bytes();
}

Job decode_job(std::string bytes) {
  ByteReader in(std::move(bytes));
  Job job;
  in.get_list(job.backends);
  in.get(job.options);
  in.get(job.set.name);
  for (std::size_t i = in.get_count(); i > 0; --i) job.set.solids.push_back(get_solid(in));
  in.get_list(job.set.pairs);
  get_each(in, job.set.poses);
  in.get_list(job.set.exact_separations);
  return job;
}

std::string encode_answers(const std::vector<BackendAnswers>& answers) {
  ByteWriter out;
  out.put(answers.size());
  for (const BackendAnswers& backend : answers) {
    out.put(backend.name);
    out.put(backend.description);
    out.put(backend.capabilities);
    for (const QueryAnswers& query : backend.queries) put(out, query);
    put(out, backend.perturbed);
    for (const auto& timing : backend.frame_by_query) put_optional(out, timing);
    put_optional(out, backend.consistency);
    out.put(backend.failure);
  }
  return out.bytes();
}

std::vector<BackendAnswers> decode_answers(std::string bytes) {
  ByteReader in(std::move(bytes));
  std::vector<BackendAnswers> answers;
  for (std::size_t i = in.get_count(); i > 0; --i) {
    BackendAnswers& backend = answers.emplace_back();
    in.get(backend.name);
    in.get(backend.description);
    in.get(backend.capabilities);
    for (QueryAnswers& query : backend.queries) get(in, query);
    get(in, backend.perturbed);
    for (auto& timing : backend.frame_by_query) get_optional(in, timing);
    get_optional(in, backend.consistency);
    in.get(backend.failure);
  }
  return answers;
}

}  // namespace touchstone::comparison
