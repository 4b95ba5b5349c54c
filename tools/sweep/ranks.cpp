#include "tools/sweep/ranks.h"

#include <limits>
#include <string>
#include <vector>

namespace sanso::sweep {

Ranks::Ranks(int* argc, char*** argv) {
  int provided = 0;
  MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);  // the planner's threads never call MPI
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  const MPI_Aint bytes = rank_ == 0 ? sizeof(int) : 0;
  MPI_Win_allocate(bytes, sizeof(int), MPI_INFO_NULL, MPI_COMM_WORLD, &counter_, &counter_window_);
  if (rank_ == 0) *counter_ = 0;
  MPI_Barrier(MPI_COMM_WORLD);
}

Ranks::~Ranks() {
  MPI_Win_free(&counter_window_);
  MPI_Finalize();
}

int Ranks::take_job() {
  const int one = 1;
  int job = 0;
  MPI_Win_lock(MPI_LOCK_SHARED, 0, 0, counter_window_);
  MPI_Fetch_and_op(&one, &job, MPI_INT, 0, 0, MPI_SUM, counter_window_);
  MPI_Win_unlock(0, counter_window_);
  return job;
}

std::vector<std::string> Ranks::gather(const std::string& text) const {
  const int length = static_cast<int>(text.size());
  std::vector<int> lengths(static_cast<std::size_t>(size_)), starts(static_cast<std::size_t>(size_));
  MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  int total = 0;
  for (std::size_t r = 0; r < lengths.size(); ++r) {
    starts[r] = total;
    total += lengths[r];
  }
  std::string all(static_cast<std::size_t>(total), ' ');
  MPI_Gatherv(text.data(), length, MPI_CHAR, all.data(), lengths.data(), starts.data(), MPI_CHAR, 0, MPI_COMM_WORLD);
  std::vector<std::string> parts;
  if (rank_ != 0) return parts;
  for (std::size_t r = 0; r < lengths.size(); ++r) {
    parts.push_back(all.substr(static_cast<std::size_t>(starts[r]), static_cast<std::size_t>(lengths[r])));
  }
  return parts;
}

void Ranks::wait_for_all() const { MPI_Barrier(MPI_COMM_WORLD); }

learn::DistributeCandidates Ranks::shared_candidates() const {
  return [rank = rank_, size = size_](const Eigen::MatrixXd& candidates, const learn::LossOfCandidate& loss) {
    // Each loss is computed by one rank and is the largest number anyone has for it: the maximum carries the bits over.
    constexpr double kNotMine = -std::numeric_limits<double>::infinity();
    std::vector<double> losses(static_cast<std::size_t>(candidates.cols()), kNotMine);
    for (Eigen::Index c = rank; c < candidates.cols(); c += size) losses[static_cast<std::size_t>(c)] = loss(candidates.col(c));
    MPI_Allreduce(MPI_IN_PLACE, losses.data(), static_cast<int>(losses.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return losses;
  };
}

}  // namespace sanso::sweep
