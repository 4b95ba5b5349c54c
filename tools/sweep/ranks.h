// What a sweep needs of MPI: who am I, take the next job, share losses. Every rank runs the same
// program.
#pragma once

#include <mpi.h>

#include "host/learn/model/identify.h"

namespace sanso::sweep {

/// MPI from construction to destruction; one a process, and every Ranks lives inside it.
class Mpi {
 public:
  Mpi(int* argc, char*** argv);
  ~Mpi();
  Mpi(const Mpi&) = delete;
  Mpi& operator=(const Mpi&) = delete;
};

/// The ranks of one communicator and the jobs they share. Made, used and destroyed by all of them
/// together.
class Ranks {
 public:
  explicit Ranks(MPI_Comm ranks = MPI_COMM_WORLD);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// The next job nobody has taken yet, counted up over all ranks: long jobs do not hold the others
  /// up.
  int take_job();
  /// From now on take_job gives every rank a number beyond all jobs.
  void take_no_more();
  /// One line from every rank, at rank 0 in the order of ranks; empty elsewhere.
  std::vector<std::string> gather(const std::string& text) const;
  /// True everywhere when it is true somewhere. All ranks must call it.
  bool any(bool here) const;

  /// Evaluates every size()-th candidate here and exchanges the losses: 8 bytes a candidate and
  /// generation. All ranks must call it with the same candidates; all get the same answer.
  learn::DistributeCandidates shared_candidates() const;

 private:
  int add_to_counter(MPI_Op operation, int value);

  MPI_Comm ranks_;
  int rank_ = 0, size_ = 1;
  MPI_Win counter_window_ = MPI_WIN_NULL;
  int* counter_ = nullptr;  // lives at rank 0
};

}  // namespace sanso::sweep
