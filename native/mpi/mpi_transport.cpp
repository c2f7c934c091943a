#include "native/mpi/mpi_transport.h"

#include <mpi.h>

#include <algorithm>
#include <utility>

namespace isosplat {

struct MpiTransport::Sending {
  std::vector<std::byte> content;
  MPI_Request request = MPI_REQUEST_NULL;
};

struct MpiTransport::Receiving {
  Message message;
  MPI_Request request = MPI_REQUEST_NULL;
  bool is_complete = false;
};

MpiTransport::MpiTransport() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
}

MpiTransport::~MpiTransport() = default;

void MpiTransport::send(int to, MessageKind kind, std::vector<std::byte> content) {
  if (to == rank_) {
    own_.push_back({rank_, kind, std::move(content)});
    return;
  }
  Sending& sending = sending_.emplace_back(Sending{std::move(content)});
  // Messages have at most a few MB.
  MPI_Isend(sending.content.data(), static_cast<int>(sending.content.size()), MPI_BYTE, to,
            static_cast<int>(kind), MPI_COMM_WORLD, &sending.request);
}

void MpiTransport::advance() {
  sending_.remove_if([](Sending& sending) {
    int is_complete = 0;
    MPI_Test(&sending.request, &is_complete, MPI_STATUS_IGNORE);
    return is_complete != 0;
  });
  for (;;) {
    int is_there = 0;
    MPI_Message incoming = MPI_MESSAGE_NULL;
    MPI_Status status{};
    MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &is_there, &incoming, &status);
    if (!is_there) break;
    int bytes = 0;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    Receiving& receiving = receiving_.emplace_back();
    receiving.message = {status.MPI_SOURCE, static_cast<MessageKind>(status.MPI_TAG),
                         std::vector<std::byte>(static_cast<size_t>(bytes))};
    MPI_Imrecv(receiving.message.content.data(), bytes, MPI_BYTE, &incoming, &receiving.request);
  }
  for (Receiving& receiving : receiving_) {
    if (receiving.is_complete) continue;
    int is_complete = 0;
    MPI_Test(&receiving.request, &is_complete, MPI_STATUS_IGNORE);
    receiving.is_complete = is_complete != 0;
  }
}

std::optional<Message> MpiTransport::receive() {
  advance();
  if (!own_.empty()) {
    Message message = std::move(own_.front());
    own_.pop_front();
    return message;
  }
  // A message that is complete may overtake those of other ranks, but none of its own rank.
  std::vector<bool> waits(static_cast<size_t>(ranks_));
  for (auto at = receiving_.begin(); at != receiving_.end(); ++at) {
    const auto from = static_cast<size_t>(at->message.from);
    if (!at->is_complete) {
      waits[from] = true;
      continue;
    }
    if (waits[from]) continue;
    Message message = std::move(at->message);
    receiving_.erase(at);
    return message;
  }
  return std::nullopt;
}

bool MpiTransport::is_busy() const {
  return !sending_.empty() || !receiving_.empty();
}

MpiSession::MpiSession(int& argc, char**& argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &ranks_on_machine_);
  MPI_Comm_free(&machine);
}

MpiSession::~MpiSession() {
  MPI_Finalize();
}

}  // namespace isosplat
