// What a sweep needs of MPI: who am I, take the next job, share losses. Every rank runs the same program.
#pragma once

#include <mpi.h>

#include "host/learn/identify.h"

namespace sanso::sweep {

/// MPI from construction to destruction; one a process. Not copyable.
class Ranks {
 public:
  Ranks(int* argc, char*** argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// The next job nobody has taken yet, counted up over all ranks: long jobs do not hold the others up.
  int take_job();
  /// One line from every rank, at rank 0 in the order of ranks; empty elsewhere.
  std::vector<std::string> gather(const std::string& text) const;
  void wait_for_all() const;

  /// Evaluates every size()-th candidate here and exchanges the losses: 8 bytes a candidate and generation. All ranks must
  /// call it with the same candidates; all get the same answer.
  learn::DistributeCandidates shared_candidates() const;

 private:
  int rank_ = 0, size_ = 1;
  MPI_Win counter_window_ = MPI_WIN_NULL;
  int* counter_ = nullptr;  // lives at rank 0
};

}  // namespace sanso::sweep
