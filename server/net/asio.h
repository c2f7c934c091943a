#pragma once

// Boost 1.74 uses std::exchange in awaitable.hpp without including its header.
#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>

// Sockets, timers and coroutines of one thread's io_context. A fixed executor type avoids the cost
// of the polymorphic any_io_executor.

namespace isosplat::server {

using Executor = boost::asio::io_context::executor_type;
using Socket = boost::asio::basic_stream_socket<boost::asio::ip::tcp, Executor>;
using Acceptor = boost::asio::basic_socket_acceptor<boost::asio::ip::tcp, Executor>;
using Timer = boost::asio::basic_waitable_timer<
    std::chrono::steady_clock, boost::asio::wait_traits<std::chrono::steady_clock>, Executor>;

template <class T>
using Awaitable = boost::asio::awaitable<T, Executor>;

constexpr boost::asio::use_awaitable_t<Executor> kAwait;

/// With this token, co_await sets the error code and does not throw. (Boost 1.74 has no as_tuple.)
inline auto await(boost::system::error_code& error) {
  return boost::asio::redirect_error(kAwait, error);
}

}  // namespace isosplat::server
