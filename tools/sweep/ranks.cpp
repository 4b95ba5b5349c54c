// Jobs by an atomic counter in rank 0's window; texts and losses by collective calls, so every
// rank has to take part in those.
#include "tools/sweep/ranks.h"

#include <limits>
#include <string>
#include <vector>

namespace sanso::sweep {

Mpi::Mpi(int* argc, char*** argv) {
  int provided = 0;
  // the planner's threads never call MPI
  MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
}

Mpi::~Mpi() { MPI_Finalize(); }

Ranks::Ranks(MPI_Comm ranks) : ranks_(ranks) {
  MPI_Comm_rank(ranks_, &rank_);
  MPI_Comm_size(ranks_, &size_);
  const MPI_Aint bytes = rank_ == 0 ? sizeof(int) : 0;
  MPI_Win_allocate(bytes, sizeof(int), MPI_INFO_NULL, ranks_, &counter_, &counter_window_);
  if (rank_ == 0) *counter_ = 0;
  MPI_Barrier(ranks_);
}

Ranks::~Ranks() { MPI_Win_free(&counter_window_); }

/// Returns the counter as it was before.
int Ranks::add_to_counter(MPI_Op operation, int value) {
  int before = 0;
  MPI_Win_lock(MPI_LOCK_SHARED, 0, 0, counter_window_);
  MPI_Fetch_and_op(&value, &before, MPI_INT, 0, 0, operation, counter_window_);
  MPI_Win_unlock(0, counter_window_);
  return before;
}

int Ranks::take_job() { return add_to_counter(MPI_SUM, 1); }
void Ranks::take_no_more() { (void)add_to_counter(MPI_MAX, std::numeric_limits<int>::max() / 2); }

std::vector<std::string> Ranks::gather(const std::string& text) const {
  const int length = static_cast<int>(text.size());
  std::vector<int> lengths(static_cast<std::size_t>(size_)),
      starts(static_cast<std::size_t>(size_));
  MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, 0, ranks_);
  int total = 0;
  for (std::size_t r = 0; r < lengths.size(); ++r) {
    starts[r] = total;
    total += lengths[r];
  }
  std::string all(static_cast<std::size_t>(total), ' ');
  MPI_Gatherv(text.data(), length, MPI_CHAR, all.data(), lengths.data(), starts.data(), MPI_CHAR, 0,
              ranks_);
  std::vector<std::string> parts;
  if (rank_ != 0) return parts;
  for (std::size_t r = 0; r < lengths.size(); ++r) {
    parts.push_back(
        all.substr(static_cast<std::size_t>(starts[r]), static_cast<std::size_t>(lengths[r])));
  }
  return parts;
}

bool Ranks::any(bool here) const {
  int anywhere = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &anywhere, 1, MPI_INT, MPI_MAX, ranks_);
  return anywhere != 0;
}

learn::DistributeCandidates Ranks::shared_candidates() const {
  return [ranks = ranks_, rank = rank_, size = size_](const Eigen::MatrixXd& candidates,
                                                      const learn::LossOfCandidate& loss) {
    // Each loss is computed by one rank and is the largest number anyone has for it: the maximum
    // carries the bits over.
    constexpr double kNotMine = -std::numeric_limits<double>::infinity();
    std::vector<double> losses(static_cast<std::size_t>(candidates.cols()), kNotMine);
    for (Eigen::Index c = rank; c < candidates.cols(); c += size)
      losses[static_cast<std::size_t>(c)] = loss(candidates.col(c));
    MPI_Allreduce(MPI_IN_PLACE, losses.data(), static_cast<int>(losses.size()), MPI_DOUBLE, MPI_MAX,
                  ranks);
    return losses;
  };
}

}  // namespace sanso::sweep
