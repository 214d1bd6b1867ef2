"""Campaigns computed: what is kept of each scene, tasks on a cluster, and one dataset of all scenes."""
