#include "server/signals.h"

#include <fmt/format.h>

#include <sys/wait.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/posix/basic_stream_descriptor.hpp>
#include <csignal>
#include <new>
#include <string>

#include "server/net/service_manager.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// A text for a line of systemd's protocol.
std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

}  // namespace

void Signals::start(bool has_files) {
  signals_.emplace(control_);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR2}) {
    // Without files to read again, SIGHUP ends the program, because its terminal was closed.
    // systemd sends SIGHUP to request a reload.
    if (signal == SIGHUP && !has_files && !has_service_manager()) continue;
    struct sigaction now {};
    // Ignored signals stay ignored: a shell ignores SIGINT for its background jobs.
    if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) {
      signals_->add(signal);
    }
  }
  wait();
}

void Signals::wait() {
  signals_->async_wait([this](const error_code& error, int signal) {
    if (error) return;
    try {
      handle(signal);
    } catch (const std::bad_alloc&) {
      ++metrics_.out_of_memory;
    }
    wait();
  });
}

void Signals::handle(int signal) {
  if (signal == SIGHUP) {
    notify_reloading();
    const Result<void> reloaded = actions_.reload();
    notify_service_manager(reloaded ? "READY=1\nSTATUS=Reloaded."
                                    : "READY=1\nSTATUS=Reload failed: " +
                                          one_line(reloaded.error().message));
  } else if (signal == SIGUSR2) {
    hand_over();
  } else if (is_handed_over_) {
    is_handed_over_ = false;
    actions_.stop_sooner(limits_.stop_time);
  } else if (stopping_) {
    actions_.close_connections();
  } else {
    log_.line("stopping: responses in progress are completed first");
    notify_service_manager("STOPPING=1");
    actions_.stop(limits_.stop_time);
  }
}

/// Starts a new process with the listening sockets, and stops this one once the new one is ready.
void Signals::hand_over() {
  if (stopping_ || has_successor_) {
    log_.line("hand-over: this process is already stopping or handing over");
    return;
  }
  const Result<Successor> successor = start_successor(listeners_.sockets());
  if (!successor) {
    log_.line("hand-over: this process goes on: " + successor.error().message);
    return;
  }
  has_successor_ = true;
  asio::co_spawn(control_, await_successor(*successor), asio::detached);
}

Awaitable<void> Signals::await_successor(Successor successor) {
  asio::posix::basic_stream_descriptor<Executor> ready(control_.get_executor(), successor.ready);
  char byte = 0;
  error_code error;
  co_await ready.async_read_some(asio::buffer(&byte, 1), await(error));
  has_successor_ = false;
  if (error || stopping_) {
    if (error) {
      log_.line("hand-over: this process goes on: the new one did not start");
    } else {
      ::kill(successor.process, SIGTERM);  // since this process is stopping too
    }
    ::waitpid(successor.process, nullptr, 0);
    co_return;
  }
  log_.line(fmt::format("handed over to process {}: responses in progress are completed here",
                        successor.process));
  notify_service_manager(fmt::format("MAINPID={}", successor.process));
  is_handed_over_ = true;
  actions_.stop(limits_.hand_over_time);
}

}  // namespace isosplat::server
