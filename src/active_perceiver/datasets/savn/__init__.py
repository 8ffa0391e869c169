"""Folders of offline AI2-THOR data as SAVN (Wortsman et al., CVPR 2019) uses them."""
