// The field values of chunks in GPU memory.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <vector>

#include "shared/core/sampling/sample_clusters.h"
#include "shared/render/samples/chunk_store.h"
#include "tests/native/renderer_test.h"

namespace isosplat::render {
namespace {

class ChunkStoreGpu : public RendererTest {};

TEST_F(ChunkStoreGpu, ValuesThatAreUploadedAgainKeepTheirBuffer) {
  VolumeGrid grid;
  grid.voxels = {9, 9, 9};
  SampleBuffers buffers;
  {
    ChunkStore chunks(buffers);
    constexpr ChunkHandle kHandle = 3;
    constexpr uint32_t kSamples = 4;
    SampleCluster cluster;
    cluster.count = kSamples;
    chunks.reserve(grid, kHandle, {0, {0, 0, 0}}, {cluster});
    const SampleRange range = chunks.reserve_field(kHandle);
    ASSERT_EQ(range.count, kSamples);
    CellCorners corners;
    corners.fill(1234);
    const std::vector<PackedField> values(kSamples, pack_field(corners));
    glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(range.offset_bytes()),
                    static_cast<GLsizeiptr>(values.size() * sizeof(PackedField)), values.data());
    buffers.confirm();
    ASSERT_TRUE(buffers.is_field_confirmed(range));

    glBindBuffer(GL_ARRAY_BUFFER, 0);
    EXPECT_EQ(chunks.reserve_field(kHandle).serial, range.serial);
    GLint bound = 0;
    glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &bound);
    EXPECT_EQ(static_cast<GLuint>(bound), buffers.field_buffer_name(range.buffer));
    EXPECT_TRUE(buffers.is_field_confirmed(range));
    std::vector<PackedField> read(kSamples);
    buffers.read_field(range, 0, read);
    for (uint32_t i = 0; i < kSamples; ++i) EXPECT_EQ(read[i], values[i]) << i;

    chunks.clear_fields();
    EXPECT_EQ(buffers.field_buffer_name(range.buffer), 0u);
  }
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

}  // namespace
}  // namespace isosplat::render
