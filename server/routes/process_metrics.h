#pragma once

#include <string>

namespace isosplat::server {

/// Appends the metrics of this process and of the program to a text in the format of Prometheus:
/// the names process_… that its client libraries use, and isosplat_build_info. What the system does
/// not tell is left out.
void add_process_metrics(std::string& text);

}  // namespace isosplat::server
