# Pointcept 1.5 and 1.6: SpUNet on a Scanmill dataset in the layout `semantic_kitti`. Copy this file to
# configs/semantic_kitti/scanmill.py.
#
#   scanmill generate training -o out/training
#   scanmill export out/training --to semantic_kitti -o POINTCEPT/data/scanmill/dataset
#   cd POINTCEPT
#   sh scripts/train.sh -g 1 -d semantic_kitti -c scanmill -n first
#
# Pointcept reads dataset/sequences/NN below data_root, where NN is a number of SemanticKITTI: 00 to 07, 09 and 10 for
# training, 08 for validation. No others are read, so that it trains on ten drives at most; the export warns of more.
_base_ = ["./semseg-spunet-v1m1-0-base.py"]

# The word "velodyne" must not occur in this path, since the program replaces it by "labels" to find the labels.
data_root = "data/scanmill"
data = dict(
    train=dict(data_root=data_root),
    val=dict(data_root=data_root),
    test=dict(data_root=data_root),
)

# The base weighs the classes by how often they occur in recorded scans. Classes that your dataset lacks (parking, ...) have
# no effect on the weights of others, but are part of the mean IoU: read the IoU of each class.
