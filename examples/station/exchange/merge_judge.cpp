#include "touchstone/examples/station/exchange/merge_judge.hpp"

#include <algorithm>

namespace touchstone::station {
namespace {

std::size_t most_objects(const StationScenes& scenes) {
  std::size_t most = 0;
  for (const auto& scene : scenes) most = std::max(most, scene->setting.object_count());
  return most;
}

}  // namespace

MergeJudge::MergeJudge(const StationScenes& scenes) : scenes_(&scenes), jobs_(kRoom), judges_(scenes.size()) {
  // Every slot has its memory from the start: the loop only copies into it.
  const std::size_t most = most_objects(scenes);
  for (std::size_t i = 0; i <= kRoom; ++i) {
    jobs_.slot()->X_WO.reserve(most);
    jobs_.push();
    jobs_.pop();
  }
}

void MergeJudge::offer(const Session& session) noexcept {
  for (const Method& method : session.flight().methods()) {
    Job* const job = jobs_.slot();
    if (job == nullptr) {
      ++passed_by_;
      continue;
    }
    job->scene = session.scene();
    job->epoch = session.epoch();
    job->frame = session.frame();
    job->method = static_cast<std::size_t>(method.kind);
    job->formation = method.formation;
    job->X_WO.assign(method.flown->poses().begin(), method.flown->poses().end());
    jobs_.push();
  }
}

const JudgeFigures& MergeJudge::take() noexcept {
  figures_.take();
  return figures_.front();
}

bool MergeJudge::work() {
  bool any = false;
  while (const Job* job = jobs_.front()) {
    judge(*job);
    jobs_.pop();
    any = true;
  }
  if (!any) return false;
  figures_.back() = so_far_;
  figures_.publish();
  return true;
}

void MergeJudge::judge(const Job& job) {
  // A reset begins the figures anew.
  if (job.epoch != so_far_.epoch) {
    so_far_ = {};
    so_far_.epoch = job.epoch;
    for (std::vector<Pose>& poses : last_) poses.clear();
  }
  MergeFigures& figures = so_far_.methods[job.method];
  std::vector<Pose>& last = last_[job.method];
  // Poses that did not change keep their verdict.
  const bool stands = job.formation == last_formation_[job.method] &&
                      std::equal(last.begin(), last.end(), job.X_WO.begin(), job.X_WO.end(), is_same);
  if (!stands) {
    std::unique_ptr<training::Judge>& judge = judges_[job.scene];
    if (!judge) judge = std::make_unique<training::Judge>((*scenes_)[job.scene]->setting);
    figures.depth_now = 0.0;
    figures.has_pair = false;
    for (const training::ShownContact& contact : judge->contacts(job.X_WO, *job.formation)) {
      if (figures.has_pair && -contact.separation <= figures.depth_now) continue;
      figures.has_pair = true;
      figures.pair = contact.solids;
      figures.depth_now = -contact.separation;
    }
    last = job.X_WO;
    last_formation_[job.method] = job.formation;
  }
  // The frame is counted either way.
  figures.judged_frame = job.frame;
  ++figures.judged;
  const std::vector<char>& is_on = job.formation->is_on;
  figures.with_off += std::find(is_on.begin(), is_on.end(), 0) != is_on.end();
  figures.merged += figures.has_pair;
  figures.depth_worst = std::max(figures.depth_worst, figures.depth_now);
}

}  // namespace touchstone::station
