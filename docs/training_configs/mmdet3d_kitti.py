# mmdetection3d 1.x: PointPillars on a Scanmill dataset in the layout `kitti`. Copy this file anywhere; mmdet3d must be
# installed.
#
#   scanmill generate training -o out/training --set output.objects=true
#   scanmill export out/training --to kitti -o MMDET3D/data/scanmill_kitti
#   cd MMDET3D
#   python tools/create_data.py kitti --root-path ./data/scanmill_kitti --out-dir ./data/scanmill_kitti --extra-tag kitti
#   python tools/train.py mmdet3d_kitti.py
#
# create_data.py writes kitti_infos_*.pkl, training/velodyne_reduced (the points in the image) and the database of objects.
_base_ = 'mmdet3d::pointpillars/pointpillars_hv_secfpn_8xb6-160e_kitti-3d-3class.py'

data_root = 'data/scanmill_kitti/'
class_names = ['Pedestrian', 'Cyclist', 'Car']

# The range is that of the base: objects ahead, from 3 m below the sensor to 1 m above it. It fits a sensor 1.7 m above the
# road. For another height h change both z by 1.73 - h, here and in the anchors of the model.
point_cloud_range = [0, -39.68, -3, 69.12, 39.68, 1]

# A class without any object in the training set stops the program with a KeyError: leave its name out below.
db_sampler = dict(
    data_root=data_root,
    info_path=data_root + 'kitti_dbinfos_train.pkl',
    rate=1.0,
    prepare=dict(
        filter_by_difficulty=[-1],
        filter_by_min_points=dict(Car=5, Pedestrian=5, Cyclist=5)),
    classes=class_names,
    sample_groups=dict(Car=15, Pedestrian=15, Cyclist=15),
    points_loader=dict(type='LoadPointsFromFile', coord_type='LIDAR', load_dim=4, use_dim=4))

# The pipeline of the base, but for use_ground_plane: the planes of the export are level, but roads may climb.
train_pipeline = [
    dict(type='LoadPointsFromFile', coord_type='LIDAR', load_dim=4, use_dim=4),
    dict(type='LoadAnnotations3D', with_bbox_3d=True, with_label_3d=True),
    dict(type='ObjectSample', db_sampler=db_sampler, use_ground_plane=False),
    dict(type='RandomFlip3D', flip_ratio_bev_horizontal=0.5),
    dict(type='GlobalRotScaleTrans', rot_range=[-0.78539816, 0.78539816], scale_ratio_range=[0.95, 1.05]),
    dict(type='PointsRangeFilter', point_cloud_range=point_cloud_range),
    dict(type='ObjectRangeFilter', point_cloud_range=point_cloud_range),
    dict(type='PointShuffle'),
    dict(type='Pack3DDetInputs', keys=['points', 'gt_labels_3d', 'gt_bboxes_3d'])
]

train_dataloader = dict(dataset=dict(dataset=dict(data_root=data_root, pipeline=train_pipeline)))
val_dataloader = dict(dataset=dict(data_root=data_root))
test_dataloader = dict(dataset=dict(data_root=data_root))
val_evaluator = dict(ann_file=data_root + 'kitti_infos_val.pkl')
test_evaluator = val_evaluator

# Mean length, width and height of Pedestrian, Cyclist and Car in the quickstart's export. Cars have their mirrors, and
# Cyclist is the rider without the bicycle, which is listed as Misc: with the base's sizes, cars barely reach the IoU of a
# positive anchor, and cyclists do not.
model = dict(bbox_head=dict(anchor_generator=dict(sizes=[[0.71, 0.64, 1.79], [0.72, 0.69, 1.71], [4.82, 2.08, 1.70]])))
