# mmdetection3d 1.x: Cylinder3D on a Scanmill dataset in the layout `semantic_kitti`. Copy this file anywhere; mmdet3d must
# be installed.
#
#   scanmill generate training -o out/training
#   scanmill export out/training --to semantic_kitti -o MMDET3D/data/scanmill_semantickitti
#   cd MMDET3D
#   python tools/train.py mmdet3d_semantickitti.py
#
# The export lists its frames itself. tools/create_data.py semantickitti must not be used: it lists the frames of the
# recorded SemanticKITTI without looking at the folder.
_base_ = 'mmdet3d::cylinder3d/cylinder3d_4xb4-3x_semantickitti.py'

data_root = 'data/scanmill_semantickitti/'
train_dataloader = dict(dataset=dict(data_root=data_root, ann_file='semantickitti_infos_train.json'))
val_dataloader = dict(dataset=dict(data_root=data_root, ann_file='semantickitti_infos_val.json'))
test_dataloader = dict(dataset=dict(data_root=data_root, ann_file='semantickitti_infos_val.json'))
