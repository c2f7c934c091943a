#pragma once

#include <deque>
#include <list>

#include "native/cluster/transport.h"

// mpi.h is included by the source alone, with the warnings of its C++ parts off.
namespace isosplat {

/// Messages between the processes that `mpirun` has started. MPI is initialised and finalised by
/// MpiSession.
class MpiTransport : public Transport {
 public:
  MpiTransport();
  ~MpiTransport() override;
  MpiTransport(const MpiTransport&) = delete;

  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  void send(int to, MessageKind kind, std::vector<std::byte> content) override;
  std::optional<Message> receive() override;
  bool is_busy() const override;

 private:
  struct Sending;
  struct Receiving;
  void advance();

  int rank_ = 0, ranks_ = 1;
  std::list<Sending> sending_;
  std::deque<Receiving> receiving_;  // in the order in which they were sent
  std::deque<Message> own_;          // from this rank to itself
};

/// MPI from its beginning to its end in this process.
class MpiSession {
 public:
  MpiSession(int& argc, char**& argv);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;

  /// How many processes of this program run on this machine, this one included.
  int ranks_on_machine() const { return ranks_on_machine_; }

 private:
  int ranks_on_machine_ = 1;
};

}  // namespace isosplat
