#pragma once

#include <string>

namespace isosplat::server {

/// Appends the metrics of this process and of the program to a text in the format of Prometheus:
/// the names process_… of its client libraries, and isosplat_build_info. Values that the system
/// does not provide are left out.
void add_process_metrics(std::string& text);

}  // namespace isosplat::server
