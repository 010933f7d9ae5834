#pragma once

#include <memory>
#include <utility>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/pipeline/scan_stage.h"

namespace lode::ingest {

/// Snaps the triangles to the lattice and sorts them by their cell.
class DereferenceStage final : public Stage {
 public:
  DereferenceStage(BuildSession& session, ScanStage& scan);

  Work run() override;
  /// Where memory holds the soup, it is made again.
  bool isOnDisk() const override { return sorter_->runCount() > 0; }
  void save(RecordWriter& record) const override { sorter_->save(record); }
  void load(RecordReader& record, bool is_used_up) override;

  std::unique_ptr<RecordSorter> takeSorted() { return std::move(sorter_); }

 private:
  void openSorter();
  void sortSoup(const PackedInput& input);
  /// @throws Error kInput if nothing, or not the model, is left after the sort.
  void checkCounts();

  BuildSession& session_;
  ScanStage& scan_;
  std::unique_ptr<RecordSorter> sorter_;
};

}  // namespace lode::ingest
