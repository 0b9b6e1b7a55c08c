// SPDX-License-Identifier: Apache-2.0
// The job's `cluster` section: how work is handed to Slurm. Nothing of it changes a byte of a result.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"

namespace scanmill::runner {

struct ClusterKeys {
  std::string partition, account, qos;  // empty: the cluster's own choice
  std::vector<std::string> extra;       // further options of sbatch, as they are
  std::vector<std::string> wrap;        // words in front of the program: a container, a module
  std::string program;                  // scanmill as the nodes find it; empty: this one's path
  std::int64_t chunk = 500;             // elements of an array at most
  std::int64_t scans_per_element = 0;   // 0: by the forecast
  double element_s = 300;               // an element is meant to run for so long
  std::int64_t spread = 16;             // elements at least, as far as there are scans
  double time_s = 0;                    // time limit of an element; 0: by the forecast
  double poll_s = 10;                   // between two looks at the queue
  double lease_s = 120;                 // an element without any sign for so long is lost
  std::int64_t resubmits = 5;           // of a scan whose node was lost; of one that others cancelled 2
};

/// Reads the section.
void read_cluster(const document::Node& section, ClusterKeys& keys, document::Problems& problems);
document::Node cluster_schema();

}  // namespace scanmill::runner
